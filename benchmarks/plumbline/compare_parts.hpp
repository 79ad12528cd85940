#pragma once
/// Finished runs of a comparison, each a file named by all that its figures depend on: an interrupted comparison goes
/// on from there.

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "compare_plan.hpp"
#include "compare_run.hpp"

class CompareParts {
 public:
  /// In RESULT.parts. Throws std::runtime_error where that folder cannot be made.
  CompareParts(const std::filesystem::path& result, const nlohmann::json& machine, std::size_t processes);

  /// What was written of this run: `run` and the estimator's `bytes`.
  std::optional<nlohmann::json> find(const CompareJob& job) const;
  void write(const CompareJob& job, const CompareRun& run) const;
  /// The folder goes, too, unless there is something else in it.
  void remove(const std::vector<CompareJob>& jobs) const;

  const std::filesystem::path& directory() const { return directory_; }

 private:
  std::string key_of(const CompareJob& job) const;
  std::filesystem::path file_of(const CompareJob& job) const;

  std::filesystem::path directory_;
  std::string circumstances_;
};
