#pragma once
/// Options of a window of frames.                                                                 docs/math/window.md

#include "plumbline/backend/extrinsics_prior.hpp"
#include "plumbline/backend/time_offset_prior.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline {

struct WindowOptions {
  LevenbergMarquardtOptions solver;
  int frame_iterations = 4;  ///< iterations for a frame that is no keyframe; tuned: docs/decisions/134 (chosen)
  /// Prior sigma of the rotation of the first pose, the origin of the world [rad]; numerics: fixes the gauge.
  double sigma_first_rotation = 1e-3;
  double sigma_first_position = 1e-3;  ///< prior sigma of the position of the first pose [m]; numerics: fixes the gauge
  /// Sigma of the distance of the first two keyframes where it is the unit of length, relative;
  /// tuned: docs/decisions/063.
  double sigma_first_scale = 1e-3;
  ExtrinsicsOptions extrinsics;   ///< prior on the extrinsics of the camera, with an IMU
  TimeOffsetOptions time_offset;  ///< prior on the time offset of the camera, with an IMU
  /// Random walk of the readout time, for the error of the motion during a frame [s/sqrt(s)];
  /// tuned: docs/decisions/133 (chosen).
  double readout_walk = 1e-3;
};

}  // namespace plumbline
