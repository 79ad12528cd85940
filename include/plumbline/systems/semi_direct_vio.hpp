#pragma once
/// Monocular-inertial odometry with points and lines, after N. Zhang, Y. Zhao, "Fast and Robust Monocular
/// Visual-Inertial Odometry Using Points and Lines" (2019): the fast lane, for a small computer.   docs/math/direct.md
///
///   static SemiDirectVio<Pinhole<float, RadTan>> vio{rig, {}};
///
/// What the paper has: the motion between two frames from the pixels of points and segments together, predicted by the
/// IMU; then every feature by itself; pose and structure refined by reprojection errors; keyframes.
///
/// What differs:
///   - Each pixel along a segment is a residual of its own. The mean of absolute values over a segment, which the paper
///     takes, hides the direction and cannot be differentiated where it matters.
///   - Segments are lines with their own covariance, found by their edge across; ends are no measurement along it.
///   - Keyframes that leave are marginalized, and velocity, biases and scale stay estimated after the start.

#include <cstddef>

#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/camera/camera_model.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <CameraModel Camera, std::size_t MaxPixels = 752 * 480, Clock TimeSource = NoClock>
using SemiDirectVio =
    Estimator<Rig<Mono<Camera, MaxPixels>, Imu>, Features<Points<400>, Lines<100>>, DirectGaussNewton<>, TimeSource>;

}  // namespace plumbline
