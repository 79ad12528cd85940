#pragma once
/// Homography of a plane seen by two calibrated views: f2 ~ H f1, H ~ R + t n^T,            docs/math/geometry.md 7
/// n . p_1 = 1 on the plane, (R, t) = T_2_1.
///
///   A_k = [f_k,a f_k,b f_k,c],  l = A_1^-1 f_1,d,  m = A_2^-1 f_2,d:   H = A_2 diag(m/l) A_1^-1              (22)
///   d = |f2 x H f1|^2 / |H f1|^2     squared sine of the angle; the other view has H^-1                      (23)
///   r = B^T n,   n = H f1 / |H f1|,   dr/dH = B^T (I - n n^T) dH f1 / |H f1|                                 (24)
///                                                        B an orthonormal basis across f2
///   H^T H = V diag(l1, 1, l3) V^T,   u = (sqrt(1 - l3) v1 +- sqrt(l1 - 1) v3) / sqrt(l1 - l3):               (25)
///   H keeps the lengths of v2, u and all between.   R = [H v2, H u, H v2 x H u] [v2, u, v2 x u]^T
///                                                   n = v2 x u,  t = (H - R) n

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/solver/symmetric_eigen.hpp"

namespace plumbline {

/// cof(A) = det(A) A^-T
template <class S>
Mat<S, 3, 3> cofactor_matrix(const Mat<S, 3, 3>& A) {
  Mat<S, 3, 3> out;
  for (int i = 0; i < 3; ++i) {
    const int i1 = (i + 1) % 3, i2 = (i + 2) % 3;
    for (int j = 0; j < 3; ++j) {
      const int j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      out(i, j) = A(i1, j1) * A(i2, j2) - A(i1, j2) * A(i2, j1);
    }
  }
  return out;
}

/// d of (23) with H, or with H^-1 and the bearings exchanged. More than any sine when H maps the point behind the view.
template <class S>
S transfer_error(const Mat<S, 3, 3>& H, const Vec<S, 3>& from, const Vec<S, 3>& to) {
  const Vec<S, 3> x = product(H, from);
  if (!(dot(x, to) > S(0))) return S(2);  // true for NaN
  return squared_norm(x.cross(to)) / squared_norm(x);
}

/// (22), |H| = 1 and det H > 0. False when no plane shows four points like this: three of them on a line in a view, or
/// some in front and others behind.
template <class S>
bool homography_of_four(const std::array<BearingPair<S>, 4>& pairs, Mat<S, 3, 3>& H) {
  Mat<S, 3, 3> A_1, A_2;
  for (int k = 0; k < 3; ++k) {
    set_block(A_1, 0, k, pairs[std::size_t(k)].f1);
    set_block(A_2, 0, k, pairs[std::size_t(k)].f2);
  }
  const Mat<S, 3, 3> C_1 = cofactor_matrix(A_1), C_2 = cofactor_matrix(A_2);  // transposed inverses, times determinants
  const S det_1 = dot(block<3, 1>(A_1, 0, 0), block<3, 1>(C_1, 0, 0));
  const S det_2 = dot(block<3, 1>(A_2, 0, 0), block<3, 1>(C_2, 0, 0));
  if (!(det_1 * det_2 > S(0))) return false;
  for (int k = 0; k < 3; ++k) {
    const S l = dot(block<3, 1>(C_1, 0, k), pairs[3].f1), m = dot(block<3, 1>(C_2, 0, k), pairs[3].f2);
    if (!(m / l > S(0))) return false;
    for (int i = 0; i < 3; ++i) A_2(i, k) *= m / l;
  }
  H = product_transposed(A_2, C_1);
  S squared = 0;
  for (int k = 0; k < 9; ++k) squared += H.data()[k] * H.data()[k];
  H *= std::copysign(S(1), det_1) / std::sqrt(squared);
  return all_finite(H);
}

/// r and J of (24); the numbers of H column by column.
template <class S>
struct HomographyError {
  bool valid;   ///< false when H maps the bearing behind the view
  Vec<S, 2> r;  ///< sines of angles
  Mat<S, 2, 9> J_r_H;

  HomographyError(const Mat<S, 3, 3>& H, const BearingPair<S>& pair) {
    const Vec<S, 3> x = product(H, pair.f1), b1 = unit_orthogonal(pair.f2), b2 = pair.f2.cross(b1);  // B
    const S inverse_length = S(1) / norm(x);
    const Vec<S, 3> n = inverse_length * x;
    valid = dot(n, pair.f2) > S(0);  // false for NaN
    for (int k = 0; k < 2; ++k) {
      const Vec<S, 3>& b = k == 0 ? b1 : b2;
      r[k] = dot(b, n);
      const Vec<S, 3> across = inverse_length * (b - r[k] * n);
      for (int m = 0; m < 9; ++m) J_r_H(k, m) = across[m % 3] * pair.f1[m / 3];
    }
  }
};

/// Gauss-Newton on (24) with the weights of a Geman-McClure loss of that scale. The norm of H, which no pair
/// determines, is fixed by one row more.
template <class S>
bool refine_homography(std::span<const BearingPair<S>> pairs, S scale, int iterations, Mat<S, 3, 3>& H) {
  for (int iteration = 0; iteration < iterations; ++iteration) {
    DenseNormalEquations<S, 9> equations;
    Mat<S, 1, 9> along;
    for (int k = 0; k < 9; ++k) along(0, k) = H.data()[k];
    equations.add(along, Vec<S, 1>(S(0)), S(pairs.size()));
    for (const BearingPair<S>& pair : pairs) {
      const HomographyError<S> error(H, pair);
      if (!error.valid) continue;
      const S w = S(1) / (S(1) + squared_norm(error.r) / (scale * scale));
      equations.add(error.J_r_H, error.r, w * w);
    }
    Vec<S, 9> d;
    if (!equations.solve(d)) return false;
    S squared = 0;
    for (int k = 0; k < 9; ++k) {
      H.data()[k] += d[k];
      squared += H.data()[k] * H.data()[k];
    }
    H *= S(1) / std::sqrt(squared);
    if (norm(d) < S(1e-6)) break;
  }
  return true;
}

/// The motions that a homography allows.
template <class S>
struct HomographyMotions {
  bool valid = false;
  SO3<S> R_nearest;              ///< the rotation nearest to H
  FixedVector<SE3<S>, 4> T_2_1;  ///< (25), translations of length 1, those in front and those behind; none if H rotates
};

/// H is taken for a rotation when |t n^T| is below `smallest`.
template <class S>
HomographyMotions<S> motions_of_homography(const Mat<S, 3, 3>& H, S smallest = S(1e-3)) {
  HomographyMotions<S> out;
  Mat<S, 3, 3> G;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) G(i, j) = dot(block<3, 1>(H, 0, i), block<3, 1>(H, 0, j));
  }
  const SymmetricEigen<S, 3> eigen(G);
  const S middle = eigen.values[1];
  if (!eigen.valid || !(eigen.values[2] > S(0))) return out;
  const Mat<S, 3, 3> unit = H * (S(1) / std::sqrt(middle));
  const Vec<S, 3> v1 = eigen.vector(0), v2 = eigen.vector(1), v3 = eigen.vector(2), Hv2 = product(unit, v2);
  const S above = std::max(eigen.values[0] / middle - 1, S(0)), below = std::max(1 - eigen.values[2] / middle, S(0));
  const auto frame = [](const Vec<S, 3>& a, const Vec<S, 3>& b) {
    Mat<S, 3, 3> F;
    set_block(F, 0, 0, a);
    set_block(F, 0, 1, b);
    set_block(F, 0, 2, Vec<S, 3>(a.cross(b)));
    return F;
  };
  const Vec<S, 3> Hv1 = normalized(product(unit, v1));  // across H v2, as v1 is across v2
  out.R_nearest = SO3<S>::from_matrix(product_transposed(frame(Hv2, Hv1), frame(v2, v1)));
  out.valid = out.R_nearest.is_finite();
  if (!out.valid || !(above + below > smallest)) return out;
  for (const S sign : {S(1), S(-1)}) {
    const Vec<S, 3> u = (std::sqrt(below) * v1 + sign * std::sqrt(above) * v3) / std::sqrt(above + below);
    const Vec<S, 3> n = v2.cross(u);
    const Mat<S, 3, 3> R = product_transposed(frame(Hv2, product(unit, u)), frame(v2, u));
    const Vec<S, 3> t = normalized(product(unit, n) - product(R, n));
    const SO3<S> rotation = SO3<S>::from_matrix(R);
    out.T_2_1.push_back(SE3<S>(rotation, t));
    out.T_2_1.push_back(SE3<S>(rotation, -t));
  }
  return out;
}

}  // namespace plumbline
