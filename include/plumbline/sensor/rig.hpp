#pragma once
/// The sensors of a robot as one type: a camera and optionally an IMU. Absence is a type, not a flag.

#include <concepts>
#include <type_traits>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

/// No IMU: no state, no memory, no code. The body frame is the camera frame.
struct NoImu {
  static constexpr bool is_present = false;
};

/// `Vision`: Mono or Rgbd, `Inertial`: Imu or NoImu.
template <class Vision, class Inertial = NoImu>
struct Rig {
  using Scalar = typename Vision::Scalar;
  using Camera = typename Vision::Camera;
  using Frame = typename Vision::Frame;
  using Shutter = typename Vision::Shutter;
  static constexpr bool has_imu = Inertial::is_present;
  static constexpr bool has_depth = Vision::has_depth;
  static constexpr bool rolls = Shutter::rolls;

  Vision vision;
  [[no_unique_address]] Inertial imu{};

  /// Extrinsics; the identity without an IMU.
  SE3<Scalar> T_body_cam() const {
    if constexpr (has_imu) {
      return imu.T_body_cam.template cast<Scalar>();
    } else {
      return {};
    }
  }
};

template <class V>
concept VisionSensor = CameraModel<typename V::Camera> && requires(const V& vision) {
  typename V::Frame;
  { V::has_depth } -> std::convertible_to<bool>;
  { vision.width } -> std::convertible_to<int>;
  { vision.height } -> std::convertible_to<int>;
  { V::Shutter::rolls } -> std::convertible_to<bool>;
  { vision.readout.get() } -> std::convertible_to<Readout<typename V::Scalar>>;
};

template <class R>
concept SensorRig = requires(const R& rig) {
  requires VisionSensor<std::remove_cvref_t<decltype(rig.vision)>>;
  { R::has_imu } -> std::convertible_to<bool>;
  { rig.T_body_cam() } -> std::same_as<SE3<typename R::Scalar>>;
};

template <class R>
concept InertialRig = SensorRig<R> && R::has_imu;

}  // namespace plumbline
