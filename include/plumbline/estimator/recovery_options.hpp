#pragma once
/// Options of what happens when frames have no pose, see outage.hpp.

#include "plumbline/sensor/rig.hpp"

namespace plumbline {

struct RecoveryOptions {
  /// Fewest landmarks in view for an initialization, or for tracking; tuned: docs/decisions/131 (chosen).
  int min_landmarks = 15;
  /// Frames without a pose before a reset, for rigs without IMU. Images of too little contrast do not count;
  /// tuned: docs/decisions/096.
  int max_lost_frames = 20;
  /// Time without a usable image after which the rotation of the camera is unknown [s];
  /// tuned: docs/decisions/131 (chosen).
  double gap_s = 0.2;
  /// Unusable images in a row before new landmarks are detected, for rigs with an IMU;
  /// tuned: docs/decisions/131 (chosen).
  int max_outage_frames = 3;
  /// Longest IMU-only propagation, or wait for a usable image, before a reset [s]; tuned: docs/decisions/016.
  double max_imu_only_s = 3;
  /// Speed of a body that is not observed, sigma [m/s]; tuned: docs/decisions/131 (chosen).
  double lost_speed = 1;
  /// Angular rate of a body that is not observed, sigma [rad/s]; tuned: docs/decisions/131 (chosen).
  double lost_rate = 1;
};

/// The default options of a rig: a new initialization without depth takes as long as ten frames, so a reset comes
/// earlier; tuned: docs/decisions/096.
template <SensorRig Sensors>
constexpr RecoveryOptions default_recovery() {
  return {.max_lost_frames = Sensors::has_depth ? 20 : 10};
}

}  // namespace plumbline
