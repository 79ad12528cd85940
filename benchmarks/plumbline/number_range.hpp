#pragma once
/// Numbers on the command line, with the range that is said when one is outside.

#include <cmath>
#include <string>

#include <CLI/CLI.hpp>

#include "format.hpp"
#include "plumbline/io/printable.hpp"
#include "plumbline/io/text.hpp"

namespace detail {

inline std::string wrong_number(const std::string& text, const char* kind, double low, double high, const char* unit) {
  return format("\"%.40s\" is not a %s from %.10g to %.10g%s%s", plumbline::io::printable(text).c_str(), kind, low,
                high, *unit ? " " : "", unit);
}

}  // namespace detail

/// A finite number, both ends included.
inline CLI::Validator number_from(double low, double high, const char* unit = "") {
  const auto check = [=](const std::string& text) {
    const auto value = plumbline::io::parse_finite(text);
    return value && *value >= low && *value <= high ? std::string()
                                                    : detail::wrong_number(text, "number", low, high, unit);
  };
  return CLI::Validator(check, "", "number").description(format("[%g to %g%s%s]", low, high, *unit ? " " : "", unit));
}

/// The same without digits after the point.
inline CLI::Validator whole_number_from(double low, double high) {
  const auto check = [=](const std::string& text) {
    const auto value = plumbline::io::parse<long long>(text);
    const bool fits = value && double(*value) >= low && double(*value) <= high;
    return fits ? std::string() : detail::wrong_number(text, "whole number", low, high, "");
  };
  return CLI::Validator(check, "", "whole number").description(format("[%g to %g]", low, high));
}
