#pragma once
/// Input of a front end for one frame: the previous and the current image, their poses, and the sensor data.

#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// The image pyramid of a rig: four levels of the largest image its camera delivers.
template <SensorRig Sensors>
using RigPyramid = Pyramid<4, decltype(Sensors::vision)::max_pixels>;

/// The shutter of the camera of a rig, for one frame.
template <SensorRig Sensors>
using RigShutter = typename Sensors::Shutter::template Model<typename Sensors::Camera>;

template <SensorRig Sensors>
struct View {
  using S = typename Sensors::Scalar;

  TimeNs t_ns;  ///< of the current frame
  S dt;         ///< since the previous frame [s]
  const Sensors& rig;
  const RigPyramid<Sensors>& previous;  ///< pyramid of the last image that was used
  const RigPyramid<Sensors>& current;
  ImageView<const std::uint16_t> depth;  ///< of the current frame; empty without a depth sensor or depth image
  SE3<S> T_world_previous;               ///< pose of the body at the previous image
  SE3<S> T_body_cam;
  RigShutter<Sensors> shutter;  ///< of the current frame

  const typename Sensors::Camera& camera() const { return rig.vision.camera; }

  /// Sets the motion of the body, in its own axes [rad/s, m/s], and the range of the scene [m] for features without
  /// one.
  void set_motion(const Vec<S, 3>& angular_rate, const Vec<S, 3>& velocity, S range) {
    const SO3<S> R_cam_body = T_body_cam.rotation().inverse();
    const Vec<S, 3> v = velocity + Vec<S, 3>(angular_rate.cross(T_body_cam.p()));
    shutter.set_motion(R_cam_body * angular_rate, R_cam_body * v, S(1) / range);
  }
};

}  // namespace plumbline
