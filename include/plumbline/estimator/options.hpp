#pragma once
/// What can be set about an estimator. Defaults suit a sensor class, never a recording.

#include "plumbline/backend/inertial_chain.hpp"
#include "plumbline/estimator/inertial_start.hpp"
#include "plumbline/estimator/readout_filter.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/imu/standstill.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

struct MotionOptions {
  int max_iterations = 10;
  double step_tolerance = 1e-5;  ///< converged below this length of the step [rad and m]
  double chi2_gate = 13.8;       ///< 99.9 % of two degrees of freedom
  int min_inliers = 8;           ///< fewer are no estimate
};

struct KeyframeOptions {
  double min_tracked_ratio;  ///< of the landmarks in sight after the last keyframe
  double max_motion_px;      ///< mean motion of the landmarks since the last keyframe
};

/// A camera without depth locates its landmarks by keyframes, and velocities and biases want them close; depth alone
/// drifts with every keyframe.
template <class Sensors>
constexpr KeyframeOptions default_keyframes() {
  if (!Sensors::has_depth) return {0.7, 30};
  return {0.5, Sensors::has_imu ? 50.0 : 80.0};
}

/// Of rigs with an IMU.
struct FusionOptions {
  double gyro_inflation = 2;  ///< of the calibrated densities: vibration, scale and alignment errors
  double accel_inflation = 5;
  double walk_inflation = 2;
  double velocity_sigma = 0.1;   ///< of the velocity that predicts a frame [m/s]
  double rotation_sigma = 5e-3;  ///< of the rotation since the last frame, beside the gyroscope's noise [rad]
  int frame_iterations = 4;      ///< of the window for a frame that is no keyframe
  double max_coasting_s = 3;     ///< on the IMU alone before the pose is called lost
  double max_disagreement = 6;   ///< of readings and images, see InertialChain; about 2 on a vibrating drone
  int max_blind_frames = 3;      ///< in a row, before new landmarks are looked for
  double rest_motion_px = 0.5;   ///< landmarks that moved less since the last frame do not contradict a standstill
  double rest_hysteresis = 2;    ///< limits are this much wider for a body at rest
  StandstillOptions standstill;
  InertialStartOptions start;
};

template <class Sensors, class Backend, class Maps>
struct EstimatorOptions {
  MotionOptions motion;
  KeyframeOptions keyframe = default_keyframes<Sensors>();
  PoseRansacOptions ransac;
  typename Backend::Options backend;
  typename Maps::Options features;
  RotationAlignmentOptions rotation;
  ReadoutOptions readout;
  FusionOptions fusion;
  double max_prediction_s = 0.5;  ///< longer gaps are not bridged by constant velocity
  int min_landmarks = 15;         ///< to start with
  int max_lost_frames = 10;       ///< tried again against the last good frame before starting anew
};

}  // namespace plumbline
