#pragma once
/// What the configurations with a sliding window share: the size of images and window, the camera model chosen at run
/// time.

#include "estimator_runner.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

namespace pl = plumbline;

inline constexpr std::size_t max_pixels = 1280 * 800;
using MonoCamera = pl::Mono<pl::AnyCamera<double>, max_pixels>;
using RgbdCamera = pl::Rgbd<pl::AnyCamera<double>, max_pixels>;

template <class Sensors, class... Kinds>
std::unique_ptr<Runner> make_window(const pl::io::Calibration& calibration) {
  using Estimator = pl::Estimator<Sensors, pl::Features<Kinds...>, pl::SlidingWindow<10>, SteadyClock>;
  return std::make_unique<EstimatorRunner<Estimator, Sensors>>(make_sensors<Sensors>(calibration));
}
