#pragma once
/// Cells and paragraphs of the tables that are printed.

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// Three digits, at most a tenth of a millimeter; "failed" of an infinite value, "-" of NaN.
std::string meters(double value);

/// Whole percents of a share, rounded down.
std::string percent(double share);

/// Median of times with one decimal; "-" of none.
std::string milliseconds(const std::vector<double>& ms);

/// A number of a JSON file with so many decimals, times `unit`; "-" of null.
std::string number(const nlohmann::json& value, int decimals, double unit = 1);

/// "1 run", "3 runs".
std::string counted(std::size_t count, const char* what);

/// CPU, memory, system, compiler and version of one line.
std::string text_of_machine(const nlohmann::json& machine);

/// Lines of at most 120 columns.
std::string wrapped(const std::string& text);
