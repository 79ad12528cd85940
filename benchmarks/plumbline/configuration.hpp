#pragma once
/// The types that configurations.cmake names: the camera model chosen at run time, and the types of
/// features for certain sensors.

#include <type_traits>

#include "largest_image.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/initialization_points.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "runner.hpp"

namespace pl = plumbline;

using MonoCamera =
    pl::Mono<pl::AnyCamera<double>, largest_image_px, pl::Rolling>;  // the calibration has the readout time
using RgbdCamera = pl::Rgbd<pl::AnyCamera<double>, largest_image_px>;

/// A camera without depth starts by points.
template <class Sensors>
using LinesAlone = std::conditional_t<Sensors::has_depth, pl::Features<pl::Lines<160>>,
                                      pl::Features<pl::InitializationPoints<200>, pl::Lines<100>>>;

template <class Sensors>
constexpr Needs needs_of() {
  return {.depth = Sensors::has_depth, .imu = Sensors::has_imu};
}
