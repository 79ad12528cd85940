#pragma once
/// Monocular-inertial odometry with points and lines, after N. Zhang, Y. Zhao, "Fast and Robust Monocular
/// Visual-Inertial Odometry Using Points and Lines" (2019): semi-direct, for small computers.   docs/math/direct.md
///
///   static SemiDirectVio<Pinhole<float, RadTan>> vio{rig, {}};
///
/// From the paper:
///   - sparse image alignment: the motion between two frames by the intensities of patches on points and along
///     segments, with the IMU's prediction as prior
///   - feature alignment: each point by itself, its reference patch warped by the relative pose
///   - refinement of pose and structure by reprojection errors; of a line the distance of its ends
///   - FAST corners and line segments in keyframes; bundle adjustment at each keyframe
///   - depth filters for points and for both ends of segments: Gaussian inverse depth, Beta inlier ratio
///   - initialization by two views, then alignment of visual poses with the preintegrated IMU
///
/// In the paper, not in this composition:
///   - the reference patch of the keyframe nearest to the new image; here it is that of the anchor, the keyframe of the
///     first observation
///   - alignment of segment ends by their pixels; here the edge is searched for across the segment
///   - the mean of absolute differences over a segment as one residual; here each sample is a residual
///   - LSD segments; here a gradient-based detector (opencv/lsd_detector.hpp has LSD)
///   - 3D end points as the parameters of a line
///   - homography or fundamental matrix, PnP and structure from motion in a window at initialization; here the relative
///     pose with the rotation of the gyroscope as first guess, and the pose refinement of every frame
///   - a mapping thread: detection and bundle adjustment run in add_frame, or beside it with an executor
///     (estimator/executor.hpp); depth filters run in every frame
///
/// In this composition, not in the paper:
///   - gain and bias of each frame in the alignment; a search along the epipolar curve for new points out of track
///   - lines with four parameters and their covariance; of an observation only the part across the edge counts
///   - velocity, biases, gravity's direction, scale, extrinsics and time offset are estimated after initialization
///   - keyframes that leave the window are marginalized, with first-estimate Jacobians
///   - recovery after visual outages and IMU faults, docs/concepts/outages.md

#include <cstddef>

#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/camera/camera_model.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/estimator/executor.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <CameraModel Camera, std::size_t MaxPixels = 752 * 480, Clock TimeSource = NoClock, class MapPolicy = NoMap,
          Executor ExecutorPolicy = SynchronousExecutor>
using SemiDirectVio = Estimator<Rig<Mono<Camera, MaxPixels>, Imu>, Features<Points<400>, Lines<100>>,
                                DirectGaussNewton<>, TimeSource, MapPolicy, ExecutorPolicy>;

}  // namespace plumbline
