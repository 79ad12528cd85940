#pragma once
/// A comparison in figures: for each configuration on each data set what its runs came to.

#include <ostream>

#include <nlohmann/json.hpp>

/// For the terminal, a block for each data set.
void print_table(std::ostream& out, const nlohmann::json& comparison);

/// For a README, a column for each data set.
void print_markdown(std::ostream& out, const nlohmann::json& comparison);
