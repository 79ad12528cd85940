#pragma once
/// The pages of benchmarks/report, which are part of the program: each is one file that needs nothing else.

#include <ostream>
#include <string_view>

#include <nlohmann/json_fwd.hpp>

/// The page `compare`, `debug`, `doctor` or `live` with its data. Text that is not UTF-8 is shown with replacement
/// characters; throws std::logic_error where there is no such page.
void write_page(std::ostream& out, std::string_view page, const nlohmann::json& data);
