#pragma once
/// Tables of a comparison: for each configuration on each data set a summary of its runs.

#include <ostream>

#include <nlohmann/json.hpp>

/// For the terminal, a block for each data set.
void print_table(std::ostream& out, const nlohmann::json& comparison);

/// For a README, a column for each data set: accuracy and time.
void print_markdown(std::ostream& out, const nlohmann::json& comparison);

/// A table for each data set, Markdown: ATE, relative error and coverage of each configuration.
void print_accuracy(std::ostream& out, const nlohmann::json& comparison);

/// A table for each data set, Markdown: the time that each configuration takes for a frame.
void print_timing(std::ostream& out, const nlohmann::json& comparison);
