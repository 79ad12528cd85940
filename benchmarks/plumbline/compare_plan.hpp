#pragma once
/// Which runs a comparison consists of: configurations x recordings x repeats, less what a recording cannot serve.

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "compare.hpp"
#include "plumbline/core/time.hpp"
#include "runner.hpp"

struct CompareDataset {
  std::filesystem::path directory;        ///< or a bag
  std::string name;                       ///< of the folder
  bool has_depth, has_imu;                ///< that can be used
  plumbline::TimeNs begin_ns;             ///< of the whole recording
  std::vector<plumbline::TimeNs> frames;  ///< of the part that is asked for
  std::string content;                    ///< changes when a file of the recording does, or its calibration
  RecordingOptions inputs;                ///< how it is read
  nlohmann::json json;                    ///< as docs/compare.schema.json has it
};

struct CompareJob {
  const Configuration* configuration;
  const CompareDataset* dataset;
  std::size_t repeat;  ///< begins at this frame
  double begin_s, duration_s;
  bool with_map = false;

  std::size_t frames() const { return dataset->frames.size() - repeat; }
};

struct ComparePlan {
  std::vector<const Configuration*> configurations;
  std::vector<CompareDataset> datasets;
  std::vector<CompareJob> jobs;       ///< point to the data sets
  std::vector<std::string> left_out;  ///< a line for each data set that some configurations cannot use
  std::vector<std::string> notes;     ///< what is said of the recordings, one line each

  explicit ComparePlan(const CompareOptions& options);  ///< throws std::runtime_error
  ComparePlan(const ComparePlan&) = delete;
  ComparePlan& operator=(const ComparePlan&) = delete;
};

/// As docs/compare.schema.json has it. An alias has the parts of the configuration it names.
nlohmann::json json_of(const Configuration& configuration);
