#pragma once
/// The table of `plumbline starts`.

#include <ostream>

#include <nlohmann/json.hpp>

/// Figures of the runs of one configuration on one recording, in one line.
void print_summary(std::ostream& out, const nlohmann::json& group);

/// Markdown: a table for each recording, a row for each configuration.
void print_initialization(std::ostream& out, const nlohmann::json& groups);
