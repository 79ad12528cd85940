#pragma once
/// RGB-D-inertial odometry with points and lines in a sliding window, after X. Zhao, C. Miao, H. Zhang, "Multi-Feature
/// Nonlinear Optimization Motion Estimation Based on RGB-D and Inertial Fusion" (2020); without its loop closure.
///
///   static RgbdInertialVio<Pinhole<float>> vio{rig, {}};
///
/// What the paper has: points by optical flow with an outlier test, lines without correspondence along the edge,
/// orthonormal line parameters; a start by vision alone that is aligned with the preintegrated IMU; keyframes by
/// parallax; Levenberg-Marquardt over poses, velocities, biases and landmarks with Huber's loss; marginalization of the
/// oldest keyframe into a prior.
///
/// What differs:
///   - Points are landmarks, inverse ranges in their anchors, observed by pixel and inverse depth, each with its noise.
///     The paper compares the 3D points of two frames with each other.
///   - Flow is corrected by alignment with the anchor's pixels. Outliers are what does not fit a pose, not a
///     fundamental matrix, which depth makes unnecessary.
///   - Lines live in their anchor's camera, not in the world, and are observed by their depth, too.
///   - What a frame that is no keyframe saw is dropped, not marginalized, when it leaves the window; its IMU readings
///     go on to the next one, as in the paper.
///   - First-estimate Jacobians. The readout time of a rolling shutter is found out while running.

#include <cstddef>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/camera_model.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <CameraModel Camera, std::size_t MaxPixels = 752 * 480, Clock TimeSource = NoClock>
using RgbdInertialVio =
    Estimator<Rig<Rgbd<Camera, MaxPixels>, Imu>, Features<Points<400>, Lines<100>>, SlidingWindow<10>, TimeSource>;

}  // namespace plumbline
