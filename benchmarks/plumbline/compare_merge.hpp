#pragma once
/// Files of comparisons: read, and put together to one.

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// Throws std::runtime_error for what is no comparison.
nlohmann::json read_comparison(const std::filesystem::path& file);

/// Runs in the order of configurations, data sets and repeats. The first file's machine stands for all; runs of another
/// one, or beside another number of processes, say so themselves. Throws std::runtime_error where the files cannot be
/// compared: another program, another part of the recordings, the same run twice.
nlohmann::json merge_comparisons(const std::vector<std::filesystem::path>& files);

void sort_runs(nlohmann::json& comparison);
