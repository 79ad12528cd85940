#pragma once
/// Epipolar constraint of two bearings of one point in two calibrated views.                docs/math/geometry.md 5
///
///   e = f2 . (t x R f1) / |t x R f1|     sine of the angle between f2 and the epipolar plane                   (14)
///                                        (R, t) = T_2_1, |t| = 1
///   given R, two pairs give t = n_i x n_j, n = R f1 x f2                                                      (15)
///   de/dphi = -(f2 x t)^T R [f1]x / |t x R f1|                                                                (16)
///   de/dt   = (R f1 x f2)^T B / |t x R f1|,   t <- normalize(t + B d),   B an orthonormal basis across t

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

template <class S>
struct BearingPair {
  Vec<S, 3> f1, f2;  ///< unit, first and second camera
};

/// (14)
template <class S>
S epipolar_error(const BearingPair<S>& pair, const SO3<S>& R, const Vec<S, 3>& t) {
  const Vec<S, 3> normal = t.cross(R * pair.f1);
  return dot(pair.f2, normal) / std::max(norm(normal), S(1e-6));
}

/// The translation (15) with the smallest sum of squared errors (14), each of them cut off at the gate.
template <class S>
bool consensus_translation(std::span<const BearingPair<S>> pairs, const SO3<S>& R, S gate, int hypotheses,
                           std::uint64_t seed, Vec<S, 3>& best) {
  Random random(seed);
  const std::uint32_t n = static_cast<std::uint32_t>(pairs.size());
  const auto normal = [&](std::uint32_t i) { return Vec<S, 3>((R * pairs[i].f1).cross(pairs[i].f2)); };
  S best_cost = S(n) * gate * gate;
  bool found = false;
  for (int h = 0; h < hypotheses; ++h) {
    const std::uint32_t i = random.below(n), j = (i + 1 + random.below(n - 1)) % n;
    const Vec<S, 3> t = normalized(normal(i).cross(normal(j)));
    S cost = 0;
    for (std::uint32_t k = 0; k < n && cost < best_cost; ++k) {
      const S e = epipolar_error(pairs[k], R, t);
      cost += std::min(gate * gate, e * e);  // the gate for NaN
    }
    if (!(cost < best_cost)) continue;
    best_cost = cost;
    best = t;
    found = true;
  }
  return found;
}

/// (16) with the weights of a Geman-McClure loss of that scale: wrong pairs are many. False when the pairs leave a
/// direction open.
template <class S>
bool refine_epipolar(std::span<const BearingPair<S>> pairs, S scale, int iterations, SO3<S>& R, Vec<S, 3>& t) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Vec<S, 3> b1 = unit_orthogonal(t), b2 = t.cross(b1);  // B
    const SO3<S> R_inverse = R.inverse();
    DenseNormalEquations<S, 5> equations;
    for (const BearingPair<S>& pair : pairs) {
      const Vec<S, 3> a = R * pair.f1, normal = t.cross(a);
      const S length = std::max(norm(normal), S(1e-6)), e = dot(pair.f2, normal) / length, q = e / scale;  // (14)
      const Vec<S, 3> u = R_inverse * Vec<S, 3>(pair.f2.cross(t));
      const Vec<S, 3> J_phi = pair.f1.cross(u), J_t = a.cross(pair.f2);
      Mat<S, 1, 5> J;  // times the length
      J << J_phi[0], J_phi[1], J_phi[2], dot(b1, J_t), dot(b2, J_t);
      const S root = S(1) / (S(1) + q * q), w = root * root / (length * length);
      if (w > S(0)) equations.add(J, Vec<S, 1>(length * e), w);  // not for NaN
    }
    Vec<S, 5> d;
    if (!equations.solve(d)) return false;
    R = R * SO3<S>::exp(segment<3>(d, 0));
    t += d[3] * b1;
    t += d[4] * b2;
    t = normalized(t);
    if (norm(d) < S(1e-6)) break;
  }
  return true;
}

}  // namespace plumbline
