#pragma once
/// Results of kind `field`: what the program answers to inputs as they come from the field.

#include <ostream>

#include <nlohmann/json.hpp>

/// The table, a row for each input: what it is, and exit status and first line of `doctor` and of `run`.
void print_field(std::ostream& out, const nlohmann::json& inputs);
