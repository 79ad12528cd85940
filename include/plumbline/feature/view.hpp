#pragma once
/// What every feature kind is given of one frame: the images, where they were taken, and the keyframes.

#include <cstdint>

#include "plumbline/image/image_view.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

/// The image pyramid of a rig: four levels of the largest image its camera delivers.
template <SensorRig Sensors>
using RigPyramid = Pyramid<4, decltype(Sensors::vision)::max_pixels>;

template <SensorRig Sensors>
struct View {
  const Sensors& rig;
  const RigPyramid<Sensors>& previous;  ///< of the last frame that was tracked
  const RigPyramid<Sensors>& current;
  ImageView<const std::uint16_t> depth;  ///< of the current frame; empty without a depth sensor or depth image
  SE3<typename Sensors::Scalar> T_body_cam;
  RollingShutter<typename Sensors::Camera> shutter;  ///< of the current frame
};

}  // namespace plumbline
