#pragma once
/// RGB-D-inertial odometry with points and lines in a sliding window, after X. Zhao, C. Miao, H. Zhang, "Multi-Feature
/// Nonlinear Optimization Motion Estimation Based on RGB-D and Inertial Fusion" (2020).         docs/math/window.md
///
///   static RgbdInertialVio<Pinhole<float>> vio{rig, {}};
///
/// From the paper:
///   - points tracked by pyramidal Lucas-Kanade flow, new ones found by FAST; outlier rejection by RANSAC
///   - lines as landmarks: orthonormal parameters; residual: distance of both segment ends from the projected line
///   - visual poses aligned with the preintegrated IMU at initialization
///   - keyframes by parallax; a window of poses, velocities, biases and landmarks; Levenberg-Marquardt, Huber loss
///   - marginalization of the oldest keyframe into a prior; of a frame that is no keyframe the IMU samples stay
///
/// In the paper, not in this composition:
///   - histogram equalization of the image, filtering of the depth image
///   - RANSAC with a fundamental matrix; here it is P3P on located points
///   - LSD segments matched by LBD descriptors; here a gradient-based detector in keyframes, and a search for the edge
///     near its prediction (opencv/lsd_detector.hpp and opencv/lbd_matching.hpp have LSD and LBD)
///   - ICP on matched 3D points for the visual poses of the initialization; here the pose refinement of every frame
///   - 3D points of two frames compared with each other, without point landmarks
///   - lines in world coordinates, triangulated
///   - a robust loss on IMU residuals and on the prior
///   - bags of words; with a map, places are known by descriptors in Hamming trees. Lines do not verify a place
///
/// Loop closure and the pose graph of the paper come with a map:
///   static RgbdInertialVio<Pinhole<float>, 640 * 480, NoClock, KeyframeMap<200>> vio{rig, {}};  docs/math/map.md
///
/// In this composition, not in the paper:
///   - points are landmarks: inverse range in the anchor keyframe, observed by pixel and inverse depth with sigmas
///   - lines are in the anchor's camera and observed by their depth, too
///   - flow is corrected by alignment with the anchor's patch
///   - gravity, velocities and accelerometer bias by the alignment, not the gyroscope bias alone
///   - first-estimate Jacobians; extrinsics, time offset and readout time of a rolling shutter are estimated
///   - recovery after visual outages and IMU faults, docs/concepts/outages.md

#include <cstddef>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/camera_model.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <CameraModel Camera, std::size_t MaxPixels = 752 * 480, Clock TimeSource = NoClock, class MapPolicy = NoMap>
using RgbdInertialVio = Estimator<Rig<Rgbd<Camera, MaxPixels>, Imu>, Features<Points<400>, Lines<100>>,
                                  SlidingWindow<10>, TimeSource, MapPolicy>;

}  // namespace plumbline
