#pragma once
/// Monocular SLAM with points and collinear points, after F. Zhang, et al., "LAP-SLAM: A Line-Assisted Point-Based
/// Monocular VSLAM" (2019).                                                                    docs/math/map.md
///
///   static LapSlam<Pinhole<float>> slam{rig, {}};
///   slam.map().S_map_world()      correction of the world, which itself never jumps
///
/// From the paper:
///   - points, and sets of points on one image segment, which stay on one line in space; segments of two keyframes are
///   the
///     same line when they share points: no line descriptor
///   - collinear residuals beside reprojection errors in the optimization of keyframes
///   - a map of keyframes: relocalization, loop closure, pose graph over Sim(3)
///
/// With KeyframeMap<200, 200, 40, true> points of the map are found again where they are expected, fused with tracked
/// ones, and the keyframes that share them are adjusted, as in the paper. It is off: docs/decisions/141.
///
/// In the paper, not in this composition:
///   - ORB features matched from frame to frame; here optical flow, corrected by alignment with the anchor's patch, and
///     binary descriptors of keyframes for places alone
///   - a bag of words; here Hamming trees that grow with the run
///   - relocalization by EPnP with line rows; here P3P on points (place_pose.hpp): docs/decisions/145
///   - lines over all keyframes of the map; here those of the window
///   - the residual as a cross product of homogeneous coordinates, whose scale is not free; here math.md 6.2
///   - the local bundle adjustment estimates the poses alone from all observations; here what the window has measured
///   is
///     its odometry and its ranges, and observations found again are added (local_adjustment.hpp)

#include <cstddef>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/camera_model.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/keyframe_map.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <CameraModel Camera, std::size_t MaxPixels = 752 * 480, Clock TimeSource = NoClock,
          class MapPolicy = KeyframeMap<200>>
using LapSlam = Estimator<Rig<Mono<Camera, MaxPixels>>, Features<Points<400>, Collinear<100>>, SlidingWindow<10>,
                          TimeSource, MapPolicy>;

}  // namespace plumbline
