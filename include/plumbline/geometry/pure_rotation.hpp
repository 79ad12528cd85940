#pragma once
/// The rotation alone that maps the bearings of one view to those of another.               docs/math/geometry.md 8
///
///   maximize sum w f2 . R f1 = q^T K q,   R = R(q), q = (x, y, z, w), with M = sum w f2 f1^T, m = sum w f1 x f2
///   K = [ M + M^T - tr(M) I   m     ]     its eigenvector of the largest eigenvalue (Davenport)               (26)
///       [ m^T                 tr(M) ]
///   w = (s^2 / (s^2 + |R f1 - f2|^2))^2   of the rotation before (Geman-McClure)

#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/solver/symmetric_eigen.hpp"

namespace plumbline {

/// From the rotation R to the one that most pairs near it agree on. False for numbers that are not finite.
template <class S>
bool refine_rotation(std::span<const BearingPair<S>> pairs, S scale, int iterations, SO3<S>& R) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    const Mat<S, 3, 3> matrix = R.matrix();
    Mat<S, 3, 3> M;
    set_zero(M);
    for (const BearingPair<S>& pair : pairs) {
      const Vec<S, 3> r = product(matrix, pair.f1) - pair.f2;
      const S root = S(1) / (S(1) + squared_norm(r) / (scale * scale));
      const S w = root > S(1e-9) ? root * root : S(0);  // 0 for NaN
      if (w == S(0)) continue;
      for (int j = 0; j < 3; ++j) {
        for (int i = 0; i < 3; ++i) M(i, j) += w * pair.f2[i] * pair.f1[j];
      }
    }
    const S trace = M(0, 0) + M(1, 1) + M(2, 2);
    Mat<S, 4, 4> K;
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) K(i, j) = M(i, j) + M(j, i) - (i == j ? trace : S(0));
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      K(3, j) = K(j, 3) = M(j2, j1) - M(j1, j2);
    }
    K(3, 3) = trace;
    const SymmetricEigen<S, 4> eigen(K);
    if (!eigen.valid || !(eigen.values[0] > eigen.values[1])) return false;
    const Mat<S, 4, 4>& V = eigen.V;
    const SO3<S> next(Eigen::Quaternion<S>(V(3, 0), V(0, 0), V(1, 0), V(2, 0)));
    const S change = squared_norm(Vec<S, 3>((R.inverse() * next).quaternion().vec()));
    R = next;
    if (change < S(1e-12)) break;
  }
  return true;
}

}  // namespace plumbline
