#pragma once
/// What computed: times are of this machine, figures of this program.

#include <cstddef>

#include <nlohmann/json.hpp>

/// As docs/compare.schema.json has it.
nlohmann::json describe_machine();

/// That this process may use.
std::size_t core_count();
