#pragma once
/// Relative pose of two calibrated views, the length of the translation left open, from a first guess of the rotation.
///                                                                                       docs/math/geometry.md 5
///   e_i = f2 . (t x R f1) / |t x R f1|     sine of the angle between f2 and the epipolar plane, (R, t) = T_2_1, |t| =
///   1
///                                                                                                             (14)
///   given R, two pairs give t = n_i x n_j, n = R f1 x f2                                                      (15)
///   de/dphi = -(f2 x t)^T R [f1]x / |t x R f1|,   de/dt = (R f1 x f2)^T B / |t x R f1|,   t <- normalize(t + B d) (16)
/// A gyroscope's bias makes the guess wrong by degrees, so (16) refines both; which of +-t holds is what puts most
/// points in front of both views. The same input gives the same output.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <Eigen/Geometry>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

template <class S>
struct BearingPair {
  Vec<S, 3> f1, f2;  ///< unit, first and second camera
};

struct TwoViewOptions {
  int hypotheses = 60;
  int iterations = 10;      ///< of (16)
  double sigma_rad = 2e-3;  ///< of a bearing, tracking errors included
  double gate = 3;          ///< inliers are within this many sigma
  std::uint64_t seed = 1;
};

template <class S, std::size_t Capacity>
struct TwoView {
  bool valid = false;  ///< a pose was found at all; whether to believe it is for the caller to say by the figures
  SE3<S> T_2_1;        ///< translation of length 1
  int inliers = 0;
  int in_front = 0;   ///< inliers in front of both views
  S parallax = S(0);  ///< median angle between f2 and R f1 of the inliers [rad]
  std::array<bool, Capacity> inlier{};
};

template <class S, std::size_t Capacity>
class TwoViewSolver {
 public:
  using Pairs = FixedVector<BearingPair<S>, Capacity>;
  using Outcome = TwoView<S, Capacity>;

  Outcome solve(const Pairs& pairs, const SO3<S>& R_guess, const TwoViewOptions& options) {
    Outcome out;
    if (pairs.size() < 8) return out;
    SO3<S> R = R_guess;
    Vec<S, 3> t;
    // The first translation is that of a rotation which may be wrong by degrees: its gate is wide.
    if (!vote(pairs, R, S(10 * options.sigma_rad), options, t)) return out;
    for (const S widening : {S(8), S(2)}) {
      if (!refine(pairs, S(widening * options.sigma_rad), options.iterations, R, t)) return out;
    }
    const S gate = S(options.gate * options.sigma_rad);
    int front = 0, behind = 0;
    angles_.clear();
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      out.inlier[i] = std::abs(error(pairs[i], R, t)) < gate;
      if (!out.inlier[i]) continue;
      ++out.inliers;
      const Vec<S, 3> a = R * pairs[i].f1, across = pairs[i].f2.cross(t);
      const S inverse_range = -pairs[i].f2.cross(a).dot(across);  // up to a positive factor
      (inverse_range > S(0) ? front : behind) += 1;
      angles_.push_back(std::atan2(a.cross(pairs[i].f2).norm(), a.dot(pairs[i].f2)));
    }
    if (behind > front) t = -t;
    out.in_front = std::max(front, behind);
    if (angles_.empty()) return out;
    const std::size_t middle = angles_.size() / 2;
    std::nth_element(angles_.begin(), angles_.begin() + middle, angles_.end());
    out.parallax = angles_[middle];
    out.T_2_1 = SE3<S>(R, t);
    out.valid = out.T_2_1.is_finite();
    return out;
  }

  /// (14)
  static S error(const BearingPair<S>& pair, const SO3<S>& R, const Vec<S, 3>& t) {
    const Vec<S, 3> normal = t.cross(R * pair.f1);
    return pair.f2.dot(normal) / std::max(normal.norm(), S(1e-6));
  }

 private:
  /// The translation (15) with the smallest truncated sum of squared errors.
  static bool vote(const Pairs& pairs, const SO3<S>& R, S gate, const TwoViewOptions& options, Vec<S, 3>& best) {
    Random random(options.seed);
    const std::uint32_t n = static_cast<std::uint32_t>(pairs.size());
    const auto normal = [&](std::uint32_t i) { return Vec<S, 3>((R * pairs[i].f1).cross(pairs[i].f2)); };
    S best_cost = S(n) * gate * gate;
    bool found = false;
    for (int h = 0; h < options.hypotheses; ++h) {
      const std::uint32_t i = random.below(n), j = (i + 1 + random.below(n - 1)) % n;
      const Vec<S, 3> t = normal(i).cross(normal(j)).normalized();
      S cost = 0;
      for (std::uint32_t k = 0; k < n && cost < best_cost; ++k) {
        const S e = error(pairs[k], R, t);
        cost += std::min(e * e, gate * gate);
      }
      if (!(cost < best_cost)) continue;
      best_cost = cost;
      best = t;
      found = true;
    }
    return found;
  }

  /// (16) with the weights of a Geman-McClure loss of that scale: wrong pairs are many.
  static bool refine(const Pairs& pairs, S scale, int iterations, SO3<S>& R, Vec<S, 3>& t) {
    for (int iteration = 0; iteration < iterations; ++iteration) {
      const Vec<S, 3> b1 = t.unitOrthogonal(), b2 = t.cross(b1);  // B
      DenseNormalEquations<S, 5> equations;
      for (const BearingPair<S>& pair : pairs) {
        const Vec<S, 3> a = R * pair.f1;
        const S length = std::max(t.cross(a).norm(), S(1e-6)), e = error(pair, R, t), q = e / scale;
        const Vec<S, 3> u = R.inverse() * Vec<S, 3>(pair.f2.cross(t));
        const Vec<S, 3> J_phi = pair.f1.cross(u), J_t = a.cross(pair.f2);
        Mat<S, 1, 5> J;  // times the length
        J << J_phi[0], J_phi[1], J_phi[2], b1.dot(J_t), b2.dot(J_t);
        const S w = S(1) / (S(1) + q * q);
        equations.add(J, Vec<S, 1>(length * e), w * w / (length * length));
      }
      Vec<S, 5> d;
      if (!equations.solve(d)) return false;
      R = R * SO3<S>::exp(segment<3>(d, 0));
      t += d[3] * b1;
      t += d[4] * b2;
      t.normalize();
      if (d.norm() < S(1e-6)) break;
    }
    return true;
  }

  FixedVector<S, Capacity> angles_;
};

}  // namespace plumbline
