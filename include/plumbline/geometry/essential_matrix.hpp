#pragma once
/// The essential matrix E = [t]x R of two calibrated views, (R, t) = T_2_1, |t| = 1.        docs/math/geometry.md 6
///
///   d = (f2^T E f1)^2 / (|E f1|^2 + |E^T f2|^2)     squared error of both bearings, each with one unit of noise (20)
///   t t^T = 1/2 tr(E E^T) I - E E^T,   R = cof(E) -+ [t]x E,  E scaled so that |t| = 1                        (21)
/// (Sampson's distance with bearings in place of pixels: it holds for every central camera.) A pair and E are explained
/// by four motions: two rotations, half a turn about t apart, with +-t each.

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
Mat<S, 3, 3> essential_matrix(const SE3<S>& T_2_1) {
  return product(hat(T_2_1.p()), T_2_1.R());
}

/// d of (20) [rad^2]; NaN where the pair has no constraint.
template <class S>
S sampson_error(const Mat<S, 3, 3>& E, const BearingPair<S>& pair) {
  S numerator = 0, denominator = 0;
  for (int i = 0; i < 3; ++i) {
    S a = 0, b = 0;
    for (int k = 0; k < 3; ++k) {
      a += E(i, k) * pair.f1[k];
      b += E(k, i) * pair.f2[k];
    }
    numerator += pair.f2[i] * a;
    denominator += a * a + b * b;
  }
  return numerator * numerator / denominator;
}

/// (21). What is not an essential matrix gives the motions of one near it; zero and NaN give some that are not finite.
template <class S>
std::array<SE3<S>, 4> motions_of_essential(const Mat<S, 3, 3>& E) {
  const Mat<S, 3, 3> G = product_transposed(E, E);
  const S half_trace = (G(0, 0) + G(1, 1) + G(2, 2)) / 2;
  int largest = 0;
  for (int k = 1; k < 3; ++k) largest = G(k, k) < G(largest, largest) ? k : largest;
  Vec<S, 3> t;
  for (int i = 0; i < 3; ++i) t[i] = (i == largest ? half_trace : S(0)) - G(i, largest);
  t = normalized(t);
  const Vec<S, 3> e0 = column(E, 0), e1 = column(E, 1), e2 = column(E, 2);
  const std::array<Vec<S, 3>, 3> cofactors{e1.cross(e2), e2.cross(e0), e0.cross(e1)};
  const S scale = std::sqrt(half_trace);
  std::array<SE3<S>, 4> out;
  for (std::size_t k = 0; k < 2; ++k) {
    Mat<S, 3, 3> R;
    for (int c = 0; c < 3; ++c) {
      const Vec<S, 3> e = block<3, 1>(E, 0, c), turned = (k == 0 ? -scale : scale) * t.cross(e);
      for (int i = 0; i < 3; ++i) R(i, c) = (cofactors[std::size_t(c)][i] + turned[i]) / half_trace;
    }
    const SO3<S> rotation = SO3<S>::from_matrix(R);
    out[2 * k] = SE3<S>(rotation, t);
    out[2 * k + 1] = SE3<S>(rotation, -t);
  }
  return out;
}

}  // namespace plumbline
