#pragma once
/// The tables of `plumbline faults`.

#include <ostream>

#include <nlohmann/json.hpp>

/// For the terminal: the run without a fault, and the head of the rows that follow.
void print_clean_run(std::ostream& out, const nlohmann::json& group);
/// For the terminal: a row of one fault.
void print_fault(std::ostream& out, const nlohmann::json& clean, const nlohmann::json& fault);

/// Markdown: a table for each recording, a column for each configuration.
void print_faults(std::ostream& out, const nlohmann::json& groups);
