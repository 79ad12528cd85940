#pragma once
/// Files of comparisons: read, and put together to one.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

/// Throws std::runtime_error for what is no comparison.
nlohmann::json read_comparison(const std::filesystem::path& file);

/// The machine is that of the first file; runs of another machine, or beside another number of processes, have a field
/// for it. Throws std::runtime_error where the files cannot be compared: another program, another part of the
/// recordings, the same run twice.
nlohmann::json merge_comparisons(const std::vector<std::filesystem::path>& files);

/// Runs that all shards together have.
std::size_t planned_runs(const nlohmann::json& comparison);

/// Puts the runs in the order of configurations, data sets and repeats. Where none is missing, drops frame_series and
/// map but for the typical run of each configuration on each data set: that whose ATE is nearest to the median, or the
/// first where all failed.
void finish(nlohmann::json& comparison);
