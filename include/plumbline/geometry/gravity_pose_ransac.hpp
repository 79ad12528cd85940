#pragma once
/// Camera pose from bearings of known points with outliers and a known gravity direction.       docs/math/geometry.md 9
///
/// MSAC over two points with (34), then Gauss-Newton on all six degrees of freedom; cost (5), refinement (7) and the
/// number of samples (6), with w^2, are those of geometry/pose_ransac.hpp. With half of the points wrong 17 samples are
/// needed for 99 %, instead of 35 of three points. The same input gives the same output.

#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/core/random_sample.hpp"
#include "plumbline/geometry/gravity_pose.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Of the poses for which passes_gate(T_cam_world) holds. up_cam is the unit up direction in the camera frame, z of the
/// world is up. The prior pose is the first hypothesis, and need not agree with up_cam.
template <class S, std::size_t Capacity>
PoseRansacResult<S, Capacity> ransac_gravity_pose(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences,
                                                  const Vec<S, 3>& up_cam, const SE3<S>& T_cam_world_prior,
                                                  const PoseRansacOptions& options, auto&& passes_gate) {
  const auto draw = [&](Random& random, auto&& offer) {
    const auto [i, j] = random_sample<2>(random, static_cast<std::uint32_t>(correspondences.size()));
    const PoseCorrespondence<S>&a = correspondences[i], &b = correspondences[j];
    const std::array<GravityPosePoint<S>, 2> points{{{a.bearing, a.p_world}, {b.bearing, b.p_world}}};
    for (const SE3<S>& T : gravity_pose(up_cam, points)) offer(T);
  };
  return pose_ransac_detail::search<2>(correspondences, T_cam_world_prior, options, passes_gate, draw);
}

template <class S, std::size_t Capacity>
PoseRansacResult<S, Capacity> ransac_gravity_pose(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences,
                                                  const Vec<S, 3>& up_cam, const SE3<S>& T_cam_world_prior,
                                                  const PoseRansacOptions& options = {}) {
  return ransac_gravity_pose(correspondences, up_cam, T_cam_world_prior, options, [](const SE3<S>&) { return true; });
}

}  // namespace plumbline
