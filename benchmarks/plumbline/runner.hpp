#pragma once
/// Every configuration of the estimator behind one interface, and the list of them (configurations.cmake); each is a
/// translation unit of its own because each is a type of its own.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <opencv2/core/mat.hpp>

#include "inspection.hpp"
#include "map_snapshot.hpp"
#include "map_timing.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/initialization/init_report.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/keyframe_map_counts.hpp"
#include "plumbline/map/map_archive.hpp"
#include "plumbline/state/health.hpp"

struct FrameOutput {
  plumbline::Estimate<double> estimate;     ///< the one before of a refused frame
  std::optional<plumbline::Error> refused;  ///< why the frame gave no estimate
  plumbline::FrameTiming timing;            ///< [s]
  plumbline::InitReport start;              ///< how far it has come, or what keeps it
  MapTiming map_timing;                     ///< part of `timing` [s]
  plumbline::KeyframeMapCounts map_counts;  ///< so far
  plumbline::Sim3<double> S_map_world;      ///< correction of the world by the map
  bool is_in_map = true;                    ///< false until a map that was taken in has been recognized
  bool is_uncertain = false;                ///< the pose is in meters that the start has only guessed so far

  /// Of the pose, in IMU time.
  plumbline::TimeNs pose_ns() const { return estimate.t_ns + std::llround(1e9 * estimate.time_offset_s); }
  plumbline::HealthState health() const { return estimate.health.state; }
  /// The body in the map; in the world where there is no map.
  plumbline::SE3<double> T_map_body() const {
    const plumbline::Sim3<double> S = S_map_world * plumbline::Sim3<double>(estimate.T_world_body);
    return {S.rotation(), S.t()};
  }
  bool has_pose() const { return !refused && health() != plumbline::HealthState::initializing; }
  bool has_sound_pose() const { return has_pose() && !is_uncertain && health() != plumbline::HealthState::lost; }
};

/// A keyframe of the map: what corrects the world at its time.
struct MapCorrection {
  plumbline::TimeNs t_ns;
  std::uint32_t world;
  plumbline::Sim3<double> S_map_world;
};

/// A loop of the map: it measured the pose of the body at the time of j in the body at that of i.
struct MapLoop {
  plumbline::TimeNs i_ns, j_ns;
  plumbline::Sim3<double> S_i_j;
};

/// What the map has done.
struct MapSummary {
  plumbline::KeyframeMapCounts counts;
  int keyframes = 0;
  std::vector<MapCorrection> corrections;
  std::vector<MapLoop> loops;
};

/// Features that the latest frame saw.
struct FeatureCounts {
  int points = 0, lines = 0;
};

/// A landmark of the present map, in world coordinates [m]: from start to end of an edge; both are one of a point.
struct MapFeature {
  int kind;          ///< of features, in the order of the estimator's
  std::uint32_t id;  ///< in its kind, never used again
  bool is_line;
  plumbline::Vec<double, 3> start, end;
};

/// Whether the estimator has a map, and whether one that is taken in stays as it is.
struct MapChoice {
  MapChoice(bool used, bool only_localizes = false) : is_used(used), localize_only(only_localizes) {}
  bool is_used, localize_only;
};

class Runner {
 public:
  virtual ~Runner() = default;
  /// Why the sample is not used; nothing where it is.
  virtual std::optional<plumbline::Error> add_imu(const plumbline::ImuSample& sample) = 0;
  /// `depth` is empty where there is none.
  virtual FrameOutput add_frame(plumbline::TimeNs t_ns, const cv::Mat& gray, const cv::Mat& depth) = 0;
  /// Of the camera: a frame needs the IMU samples up to its time stamp plus this.
  virtual double time_offset_s() const = 0;
  /// Points of the present map, in world coordinates [m].
  virtual std::vector<plumbline::Vec<double, 3>> landmarks() const = 0;
  /// Points and edges of the present map that are worth a picture: their distances are known to a fifth.
  virtual std::vector<MapFeature> map() const = 0;
  /// Takes a saved map in, before the first frame; a map is used.
  virtual plumbline::MapArchiveError load_map(std::span<const std::byte> bytes) = 0;
  /// The map with the keyframes of the window; a map is used. The run is over.
  virtual std::vector<std::byte> saved_map() = 0;
  /// Nothing without a map.
  virtual std::optional<MapSummary> map_summary() const = 0;
  virtual FeatureCounts seen() const = 0;
  /// Of the estimator, all that it ever uses.
  virtual std::size_t bytes() const = 0;
  /// What there is to see of the latest frame.
  virtual Inspection inspect() const = 0;
  /// Nothing without a map; at most so many points.
  virtual std::optional<MapSnapshot> map_snapshot(std::size_t most_points) const = 0;
};

/// What a recording must have, or has, beside a camera.
struct Needs {
  bool depth, imu;
};

struct Configuration {
  const char* name;  ///< <sensor>/<features>/<backend>, or that of a published system
  Needs needs;
  std::unique_ptr<Runner> (*make)(const plumbline::io::Calibration& calibration,
                                  MapChoice map);  ///< throws std::runtime_error
};

/// Of a system that always has a map.
template <auto Make>
std::unique_ptr<Runner> make_with_map(const plumbline::io::Calibration& calibration, MapChoice map) {
  map.is_used = true;
  return Make(calibration, map);
}

std::span<const Configuration> configurations();
/// Throws std::runtime_error with the nearest name there is.
const Configuration& configuration_named(const std::string& name);

/// The one to begin with for a recording that has these: it uses most of them. Throws std::runtime_error where this
/// program has none.
const Configuration& recommended_for(const Needs& there);
