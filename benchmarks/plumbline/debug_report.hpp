#pragma once
/// The folder that `plumbline run --debug` writes:
///   frames/NNNNNN.jpg    see frame_picture.hpp
///   frames.csv           one row for each frame
///   error.csv            error and NEES of each pose, where there is a truth
///   trajectory.png
///   report.html          all of it on one page

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "debug_page.hpp"
#include "inspection.hpp"
#include "marks.hpp"
#include "plumbline/io/trajectory.hpp"
#include "runner.hpp"
#include "table.hpp"
#include "truth_comparison.hpp"

struct DebugOptions {
  std::filesystem::path directory;                 ///< made; must not exist or be empty
  std::size_t every = 1;                           ///< n-th frame gets a picture
  std::optional<std::filesystem::path> reference;  ///< true trajectory instead of the recording's own
};

class DebugReport {
 public:
  /// `title`: one line for the page; `truth` is empty where there is none. Throws std::runtime_error when the folder
  /// cannot be used.
  DebugReport(const DebugOptions& options, std::string title, plumbline::io::Trajectory truth);

  /// The frame `number` of the recording, counted from 0; `inspection` was made after it.
  void add(std::size_t number, plumbline::TimeNs t_ns, const cv::Mat& gray, const FrameOutput& output,
           const Inspection& inspection);

  /// The files about the whole run. `summary`: text for the page; `map`: nothing without one.
  void finish(const std::string& summary, const std::optional<MapSummary>& map,
              const plumbline::io::MapContents& contents);

 private:
  DebugMap map_of_run(const MapSummary& map, const plumbline::io::MapContents& contents,
                      const plumbline::io::Trajectory& estimate, const plumbline::io::Trajectory& truth) const;
  void add_row(std::size_t number, plumbline::TimeNs t_ns, const FrameOutput& output, const Inspection& now,
               const std::vector<std::vector<Mark>>& marks);
  void add_inertial(const InertialInspection& inertial);
  void write_errors(const std::vector<TruthError>& errors) const;

  DebugOptions options_;
  std::string title_;
  plumbline::io::Trajectory truth_;
  Table frames_;
  std::vector<plumbline::TimeNs> times_;
  std::vector<plumbline::HealthState> health_;
  std::vector<DebugPage::Picture> pictures_;
  std::vector<EstimatedPose> poses_;
  bool has_imu_ = false;
  std::vector<std::string> kinds_;
  std::optional<Inspection> before_;
  plumbline::io::Trajectory in_map_, relocalizations_;
  int relocalized_ = 0;
  std::optional<plumbline::Sim3<double>> first_correction_;  // of the poses in the map
};
