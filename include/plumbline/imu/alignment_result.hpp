#pragma once
/// Result of a visual-inertial alignment (imu/alignment.hpp), or the reason why there is none.

#include <concepts>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

enum class AlignmentOutcome : std::uint8_t {
  aligned,
  too_few_frames,
  no_imu_data,          ///< an increment is empty or not finite
  rotations_disagree,   ///< of camera and gyroscope: wrong poses, extrinsics or time stamps
  positions_disagree,   ///< of camera and accelerometer: the scale of the poses has drifted, or they are wrong
  gravity_implausible,  ///< norm of gravity: wrong poses, units or extrinsics
  gravity_uncertain,    ///< direction of gravity not determined yet
  scale_uncertain,      ///< scale not determined yet: it needs accelerated motion
};

/// For logs.
constexpr const char* name_of(AlignmentOutcome outcome) {
  switch (outcome) {
    case AlignmentOutcome::aligned: return "aligned";
    case AlignmentOutcome::too_few_frames: return "too few frames";
    case AlignmentOutcome::no_imu_data: return "no IMU data";
    case AlignmentOutcome::rotations_disagree: return "camera and gyroscope turn differently";
    case AlignmentOutcome::positions_disagree: return "camera and accelerometer move differently";
    case AlignmentOutcome::gravity_implausible: return "gravity of a wrong length";
    case AlignmentOutcome::gravity_uncertain: return "gravity uncertain";
    case AlignmentOutcome::scale_uncertain: return "scale uncertain";
  }
  return "unknown outcome";
}

/// Whether poses and IMU samples contradict each other: no motion, gravity and biases explain both.
constexpr bool contradicts(AlignmentOutcome outcome) {
  return outcome == AlignmentOutcome::rotations_disagree || outcome == AlignmentOutcome::positions_disagree ||
         outcome == AlignmentOutcome::gravity_implausible;
}

template <std::floating_point S, int MaxFrames>
struct InertialAlignment {
  AlignmentOutcome outcome = AlignmentOutcome::too_few_frames;
  SO3<S> R_world_ref;
  S scale = S(1);  ///< meters in one unit of the camera poses
  Vec<S, 3> bias_gyro = zeros<S, 3>(), bias_accel = zeros<S, 3>();
  FixedVector<Vec<S, 3>, std::size_t(MaxFrames)> v_world_body;  ///< for each frame [m/s]
  // Figures, up to the step that was reached:
  double gyro_residual = 0;     ///< rms rotation between camera and gyroscope [rad]
  double excitation = 0;        ///< rms change of the specific force between frames [m/s^2]
  double gravity_norm = 0;      ///< norm of gravity while it is free [m/s^2]
  double gravity_sigma = 0;     ///< sigma of the direction of gravity [rad]
  double scale_sigma = 0;       ///< sigma of the scale, relative
  double accel_bias_sigma = 0;  ///< largest sigma of the accelerometer bias over the axes [m/s^2]
  double chi2 = 0;              ///< per degree of freedom; the sigmas above are multiplied by its square root if > 1

  explicit operator bool() const { return outcome == AlignmentOutcome::aligned; }
  /// Whether all quantities were estimated, but gravity or scale with a large sigma.
  bool is_uncertain() const {
    return !v_world_body.empty() &&
           (outcome == AlignmentOutcome::gravity_uncertain || outcome == AlignmentOutcome::scale_uncertain);
  }
  bool contradicts() const { return plumbline::contradicts(outcome); }

  /// State of frame k. The world has the origin of `ref`.
  NavState<S> state(std::size_t k, const SE3<S>& T_ref_cam, const SE3<S>& T_body_cam) const {
    const SE3<S> T_world_cam(R_world_ref * T_ref_cam.rotation(), R_world_ref * Vec<S, 3>(scale * T_ref_cam.p()));
    return {T_world_cam * T_body_cam.inverse(), v_world_body[k], bias_gyro, bias_accel};
  }
};

}  // namespace plumbline
