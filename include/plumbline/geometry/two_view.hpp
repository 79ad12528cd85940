#pragma once
/// Relative pose of two calibrated views, the length of the translation left open, from a first guess of the rotation.
///                                                                                       docs/math/geometry.md 5
///   (15) is the consensus for the translation, (16) refines both: a gyroscope's bias makes the guess wrong by degrees
///   front:  -(f2 x R f1) . (f2 x t) > 0, the inverse range by (11) up to a positive factor
/// Which of +-t holds is what puts most points in front of both views. The same input gives the same output.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

struct TwoViewOptions {
  int hypotheses = 60;
  int iterations = 10;      ///< of (16)
  double sigma_rad = 2e-3;  ///< of a bearing, tracking errors included
  double gate = 3;          ///< inliers are within this many sigma
  std::uint64_t seed = 1;
};

template <class S, std::size_t Capacity>
struct TwoView {
  bool valid = false;  ///< a pose was found at all; the caller accepts or rejects it by the figures
  SE3<S> T_2_1;        ///< translation of length 1
  int inliers = 0;
  int in_front = 0;   ///< inliers in front of both views
  S parallax = S(0);  ///< median angle between f2 and R f1 of the inliers [rad]
  std::array<bool, Capacity> inlier{};

  /// Fills all of it for a pose whose translation may have the wrong sign.
  void describe(std::span<const BearingPair<S>> pairs, const SO3<S>& R, Vec<S, 3> t, S gate) {
    int front = 0, behind = 0;
    FixedVector<S, Capacity> angles;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      inlier[i] = std::abs(epipolar_error(pairs[i], R, t)) < gate;
      if (!inlier[i]) continue;
      ++inliers;
      const Vec<S, 3> a = R * pairs[i].f1, across = pairs[i].f2.cross(t);
      const S inverse_range = -dot(pairs[i].f2.cross(a), across);  // up to a positive factor
      (inverse_range > S(0) ? front : behind) += 1;
      angles.push_back(elementary::atan2(norm(a.cross(pairs[i].f2)), dot(a, pairs[i].f2)));
    }
    if (behind > front) t = -t;
    in_front = std::max(front, behind);
    if (angles.empty()) return;
    const std::size_t middle = angles.size() / 2;
    std::nth_element(angles.begin(), angles.begin() + middle, angles.end());
    parallax = angles[middle];
    T_2_1 = SE3<S>(R, t);
    valid = T_2_1.is_finite();
  }
};

template <class S, std::size_t Capacity>
class TwoViewSolver {
 public:
  using Pairs = FixedVector<BearingPair<S>, Capacity>;
  using Outcome = TwoView<S, Capacity>;

  Outcome solve(const Pairs& pairs, const SO3<S>& R_guess, const TwoViewOptions& options) {
    Outcome out;
    if (pairs.size() < 8) return out;
    const std::span<const BearingPair<S>> all(pairs.data(), pairs.size());
    SO3<S> R = R_guess;
    Vec<S, 3> t;
    // The first translation is that of a rotation which may be wrong by degrees: its gate is wide.
    if (!consensus_translation(all, R, S(10 * options.sigma_rad), options.hypotheses, options.seed, t)) return out;
    for (const S widening : {S(8), S(2)}) {
      if (!refine_epipolar(all, S(widening * options.sigma_rad), options.iterations, R, t)) return out;
    }
    out.describe(all, R, t, S(options.gate * options.sigma_rad));
    return out;
  }
};

}  // namespace plumbline
