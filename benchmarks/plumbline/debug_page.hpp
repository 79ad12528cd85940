#pragma once
/// The page of a debug folder: pictures of the frames beside charts of everything over time (benchmarks/report).

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/core/time.hpp"
#include "plumbline/io/map_file.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/state/health.hpp"
#include "runner.hpp"
#include "table.hpp"
#include "truth_comparison.hpp"

/// The map of a run, and the run in it.
struct DebugMap {
  MapSummary summary;
  plumbline::io::MapContents contents;
  plumbline::io::Trajectory odometry;  ///< the world, with the first correction that it got in the map
  plumbline::io::Trajectory causal;    ///< as published with each frame
  plumbline::io::Trajectory final;     ///< as corrected at the end of the run
  plumbline::io::Trajectory truth;     ///< moved as the odometry is; empty where there is none
  plumbline::io::Trajectory relocalizations;
  std::vector<double> ate_m;  ///< of odometry, causal and final poses; empty without truth
};

struct DebugPage {
  struct Picture {
    std::size_t row;
    std::string file;  ///< beside the page
  };

  const std::string& title;
  const std::string& summary;
  const Table& frames;                          ///< frames.csv
  const std::vector<plumbline::TimeNs>& times;  ///< of its rows
  const std::vector<plumbline::HealthState>& health;
  const std::vector<Picture>& pictures;
  const std::vector<std::string>& kinds;  ///< of features: prefixes of columns
  bool has_imu;
  const std::vector<TruthError>& errors;  ///< empty without truth
  const plumbline::io::Trajectory& estimate;
  const plumbline::io::Trajectory& truth;  ///< in the estimate's world; empty where there is none
  const DebugMap* map;                     ///< nullptr without one
};

/// Throws std::runtime_error when it cannot be written. At least one row.
void write_debug_page(const std::filesystem::path& html, const DebugPage& page);
