#pragma once
/// Camera pose from bearings of known points with outliers: MSAC over P3P, then Gauss-Newton.   docs/math/geometry.md 2
///
///   cost(T)  = sum_i min(e_i^2 / sigma_i^2, chi2) + min(d_i^2 / sigma_d^2, chi2)                                (5)
///   e        = |b x p| / |p|, sine of the angle,  p = T_cam_world p_world
///   d        = 1/p_z - measured, for points whose depth was measured
///   n(w)     = log(1 - confidence) / log(1 - w^3) samples, w = the best inlier ratio so far                     (6)
///   r        = p/|p| - b,  J_r_T = (I - n n^T)/|p| [-R [p_world]x, R],  n = p/|p|                               (7)
/// Inliers are decided by bearings alone; depth distinguishes poses with the same bearings (few points, or all on a
/// plane). The prior pose is the first hypothesis. The same input gives the same output.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <Eigen/Geometry>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/core/random_sample.hpp"
#include "plumbline/geometry/p3p.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

template <class S>
struct PoseCorrespondence {
  Vec<S, 3> bearing;             ///< unit, camera frame
  Vec<S, 3> p_world;             ///< [m]
  S sigma_rad;                   ///< angular noise of the bearing
  S inverse_depth = S(0);        ///< measured 1/z [1/m]
  S sigma_inverse_depth = S(0);  ///< [1/m]; 0 where no depth was measured
};

struct PoseRansacOptions {
  int max_iterations = 60;
  double confidence = 0.99;  ///< of having drawn one sample without outliers
  double chi2 = 5.991;       ///< 95 % of two degrees of freedom
  std::uint64_t seed = 1;
  double prior_is_enough = 0.9;  ///< no sampling when the prior pose explains this part of the points
  int min_inliers = 5;           ///< fewer give no valid pose; three are explained by construction
};

template <class S, std::size_t Capacity>
struct PoseRansacResult {
  bool valid = false;
  SE3<S> T_cam_world;
  int inliers = 0;
  std::array<bool, Capacity> inlier{};
};

/// r and J_r_T of (7) for a small angle between bearing and prediction.
template <class S>
struct BearingError {
  Vec<S, 3> r;         ///< [rad]
  Mat<S, 3, 6> J_r_T;  ///< right increment (dphi, dp) of T_cam_world

  BearingError(const SE3<S>& T_cam_world, const Mat<S, 3, 3>& R, const PoseCorrespondence<S>& c) {
    const Vec<S, 3> p = R * c.p_world + T_cam_world.p();
    const S inverse_range = S(1) / norm(p);
    const Vec<S, 3> n = p * inverse_range;
    r = n - c.bearing;
    for (int j = 0; j < 3; ++j) {
      const Vec<S, 3> R_j = column(R, j), N_j = inverse_range * (R_j - dot(n, R_j) * n);
      set_block(J_r_T, 0, 3 + j, N_j);
    }
    set_block(J_r_T, 0, 0, product(block<3, 3>(J_r_T, 0, 3), hat(-c.p_world)));
  }
};

namespace pose_ransac_detail {

/// MSAC cost (5); ends as soon as it exceeds `limit`. Marks inliers on request.
template <class S, std::size_t Capacity>
S cost(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences, const SE3<S>& T_cam_world, S chi2, S limit,
       PoseRansacResult<S, Capacity>* marked = nullptr) {
  const Mat<S, 3, 3> R = T_cam_world.R();
  S sum = 0;
  for (std::size_t i = 0; i < correspondences.size() && sum < limit; ++i) {
    const PoseCorrespondence<S>& c = correspondences[i];
    const Vec<S, 3> p = R * c.p_world + T_cam_world.p();
    const S gate = c.sigma_rad * c.sigma_rad * squared_norm(p), error = squared_norm(c.bearing.cross(p));
    const bool inlier = error < chi2 * gate && dot(c.bearing, p) > 0;  // false for NaN
    sum += inlier ? error / gate : chi2;
    if (c.sigma_inverse_depth > S(0)) {
      const S d = (S(1) / p.z() - c.inverse_depth) / c.sigma_inverse_depth;
      sum += d * d < chi2 ? d * d : chi2;
    }
    if (marked) {
      marked->inlier[i] = inlier;
      marked->inliers += inlier;
    }
  }
  return sum;
}

/// Gauss-Newton on (7) with weights (g / (g + e^2))^2: g starts wide, so that a pose from three noisy points, or one
/// that fits none, is pulled to the consensus around it, and closes to the gate of (5).
template <class S, std::size_t Capacity>
SE3<S> refine(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences, SE3<S> T_cam_world, S chi2) {
  for (const S widening : {S(400), S(16), S(4), S(1), S(1)}) {
    const auto weight = [gate = widening * chi2](S e2) {
      const S w = gate / (gate + e2);
      return w * w;
    };
    DenseNormalEquations<S, 6> equations;
    const Mat<S, 3, 3> R = T_cam_world.R();
    for (const PoseCorrespondence<S>& c : correspondences) {
      const BearingError<S> error(T_cam_world, R, c);
      const S information = S(1) / (c.sigma_rad * c.sigma_rad);
      const S w = information * weight(information * squared_norm(error.r));
      if (!(w > S(0))) continue;
      equations.add(error.J_r_T, error.r, w);
      if (!(c.sigma_inverse_depth > S(0))) continue;
      const Vec<S, 3> e_z(R(2, 0), R(2, 1), R(2, 2)), turn = c.p_world.cross(e_z);  // d z / dp, d z / dphi
      const S z = dot(e_z, c.p_world) + T_cam_world.p().z(), slope = S(-1) / (z * z * c.sigma_inverse_depth);
      const S d = (S(1) / z - c.inverse_depth) / c.sigma_inverse_depth, w_d = weight(d * d);
      if (!(w_d > S(0))) continue;
      Mat<S, 1, 6> J;
      for (int k = 0; k < 3; ++k) {
        J(0, k) = slope * turn[k];
        J(0, 3 + k) = slope * e_z[k];
      }
      equations.add(J, Vec<S, 1>(d), w_d);
    }
    Vec<S, 6> d;
    if (!equations.solve(d)) break;
    T_cam_world = plus(T_cam_world, d);
  }
  return T_cam_world;
}

/// The best pose by (5), refined. draw(random, offer) offers the poses of one minimal sample of `SampleSize` points.
template <int SampleSize, class S, std::size_t Capacity>
PoseRansacResult<S, Capacity> search(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences,
                                     const SE3<S>& T_cam_world_prior, const PoseRansacOptions& options,
                                     auto&& passes_gate, auto&& draw) {
  using Outcome = PoseRansacResult<S, Capacity>;
  const std::size_t n = correspondences.size();
  const S chi2 = S(options.chi2), infinity = std::numeric_limits<S>::infinity();
  S best_cost = infinity;
  Outcome best;

  const auto adopt_if_better = [&](const SE3<S>& T) {
    if (!(cost(correspondences, T, chi2, best_cost) < best_cost) || !passes_gate(T)) return false;
    best = Outcome{};
    best.T_cam_world = T;
    best_cost = cost(correspondences, T, chi2, infinity, &best);
    return true;
  };
  const auto offer = [&](const SE3<S>& T) {
    if (adopt_if_better(T)) adopt_if_better(refine(correspondences, T, chi2));
  };
  const auto samples_needed = [&] {  // (6)
    return plumbline::samples_needed(options.confidence, static_cast<double>(best.inliers) / static_cast<double>(n),
                                     SampleSize);
  };

  offer(T_cam_world_prior);
  const bool prior_is_enough = best.inliers >= options.prior_is_enough * static_cast<double>(n);
  if (n > SampleSize && !prior_is_enough) {
    Random random(options.seed);
    for (int iteration = 0; iteration < options.max_iterations && iteration < samples_needed(); ++iteration) {
      draw(random, offer);
    }
  }
  best.valid = best.inliers >= options.min_inliers;
  return best;
}

}  // namespace pose_ransac_detail

/// Of the poses for which passes_gate(T_cam_world) holds.
template <class S, std::size_t Capacity>
PoseRansacResult<S, Capacity> ransac_pose(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences,
                                          const SE3<S>& T_cam_world_prior, const PoseRansacOptions& options,
                                          auto&& passes_gate) {
  const auto draw = [&](Random& random, auto&& offer) {
    const std::uint32_t count = static_cast<std::uint32_t>(correspondences.size());
    const std::uint32_t i = random.below(count);
    const std::uint32_t j = (i + 1 + random.below(count - 1)) % count;
    std::uint32_t k = random.below(count - 2);  // the k-th of those that are neither i nor j
    k += k >= std::min(i, j);
    k += k >= std::max(i, j);
    const PoseCorrespondence<S>&a = correspondences[i], &b = correspondences[j], &c = correspondences[k];
    for (const SE3<S>& T : p3p<S>({a.bearing, b.bearing, c.bearing}, {a.p_world, b.p_world, c.p_world})) offer(T);
  };
  return pose_ransac_detail::search<3>(correspondences, T_cam_world_prior, options, passes_gate, draw);
}

template <class S, std::size_t Capacity>
PoseRansacResult<S, Capacity> ransac_pose(const FixedVector<PoseCorrespondence<S>, Capacity>& correspondences,
                                          const SE3<S>& T_cam_world_prior, const PoseRansacOptions& options = {}) {
  return ransac_pose(correspondences, T_cam_world_prior, options, [](const SE3<S>&) { return true; });
}

}  // namespace plumbline
