#pragma once
/// What `plumbline run --debug` looks at after a frame: plain data, the same of every configuration.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/initialization/init_report.hpp"

/// Where a frame shows a landmark [px]: from start to end of an edge; both are one place of a point.
struct Sighting {
  std::uint32_t id;
  bool located;
  plumbline::Vec<float, 2> start, end;
};

/// How far an observation is from where the published pose has its landmark.
struct Innovation {
  double px;     ///< of an edge: root mean square of its ends
  double sigma;  ///< in standard deviations of both together, two degrees of freedom: their median should be 1.18
};

/// One kind of features.
struct FeatureInspection {
  const char* name;  ///< points, lines or collinear
  bool are_lines;
  std::size_t landmarks;                 ///< in the map
  std::vector<Sighting> seen, rejected;  ///< by the frame; what does not fit its pose is rejected
  std::vector<Innovation> innovations;   ///< of what is seen and located, once there is a pose
};

/// Of rigs with an IMU.
struct InertialInspection {
  plumbline::InitReport start;
  bool is_stationary;
  plumbline::ImuCoverage coverage;                 ///< of the time since the last frame
  double gyro_full_scale, accel_full_scale;        ///< of the calibration, or as detected [rad/s], [m/s^2]
  std::optional<plumbline::Vec<double, 9>> sigma;  ///< of velocity, gyroscope bias, accelerometer bias
  double time_offset_s;                            ///< of the camera, in addition to the calibration's
  double sigma_time_offset_s;

  // How the camera sits against T_body_camera, in the axes of the body [rad], [m].
  plumbline::Vec<double, 3> turned = plumbline::Vec<double, 3>::Zero(), moved = turned;
  plumbline::Vec<double, 3> sigma_turned = turned, sigma_moved = turned;
  bool corrects_extrinsics = false;  ///< the estimator uses that correction
};

struct Inspection {
  plumbline::Estimate<double> estimate;
  double readout_s;  ///< of the camera, as far as it is known
  std::vector<FeatureInspection> features;
  std::optional<InertialInspection> inertial;
};
