#pragma once
/// What is said of a misspelled name.

#include <string>
#include <string_view>
#include <vector>

#include "plumbline/io/nearest.hpp"

/// `kind "name" is unknown, did you mean "nearest"?`, or where none is near, all that are known.
inline std::string unknown_name(std::string_view kind, std::string_view name, const std::vector<std::string>& known) {
  return std::string(kind) + " \"" + std::string(name) + "\" is unknown, " + plumbline::io::suggestion(name, known);
}
