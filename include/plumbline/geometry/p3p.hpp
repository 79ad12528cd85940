#pragma once
/// Camera pose from three bearings of known points (P3P): at most four poses.               docs/math/geometry.md 1
///
/// With depths x = (d1, d2, d3) along the unit bearings b_i and squared sides a_ij = |p_i - p_j|^2:
///   x^T M_ij x = d_i^2 - 2 (b_i . b_j) d_i d_j + d_j^2 = a_ij                                                (1)
///   x^T D1 x = x^T D2 x = 0,  D1 = a23 M12 - a12 M23,  D2 = a23 M13 - a13 M23                                (2)
///   det(D1 + g D2) = 0: a member of the pencil is a pair of lines, D1 + g D2 = (l m^T + m l^T)/2            (3)
///   each line meets the conics (2) in two points x; the scale comes from (1), then Newton on (1) polishes x    (4)
/// Only one real root of the cubic (3) is needed, and the one farthest from the others is taken.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

namespace p3p_detail {

template <class S>
Mat<S, 3, 3> columns(const Vec<S, 3>& a, const Vec<S, 3>& b, const Vec<S, 3>& c) {
  Mat<S, 3, 3> out;
  set_block(out, 0, 0, a);
  set_block(out, 0, 1, b);
  set_block(out, 0, 2, c);
  return out;
}

template <class S>
Mat<S, 3, 3> adjugate(const Mat<S, 3, 3>& A) {  // of a symmetric matrix
  const Vec<S, 3> a0 = column(A, 0), a1 = column(A, 1), a2 = column(A, 2);
  return columns<S>(a1.cross(a2), a2.cross(a0), a0.cross(a1));
}

/// The real root of g^3 + b g^2 + c g + d farthest from the others.
template <class S>
S isolated_root(S b, S c, S d) {
  const S p = (c - b * b / 3) / 3, q = (2 * b * b * b / 27 - b * c / 3 + d) / 2;  // t^3 + 3 p t + 2 q, t = g + b/3
  const S discriminant = q * q + p * p * p;
  S t;
  if (discriminant >= 0) {
    const S u = elementary::cbrt(-q - std::copysign(std::sqrt(discriminant), q));
    t = u == 0 ? S(0) : u - p / u;
  } else {
    const S root = std::sqrt(-p);
    t = -std::copysign(
        2 * root * elementary::cos(elementary::acos(std::min(std::abs(q) / (root * root * root), S(1))) / 3), q);
  }
  S g = t - b / 3;
  for (int i = 0; i < 2; ++i) {
    const S slope = (3 * g + 2 * b) * g + c;
    if (slope != 0) g -= (((g + b) * g + c) * g + d) / slope;
  }
  return g;
}

/// The two lines l, m of a degenerate conic (3), unit normals; false when they are complex.
template <class S>
bool split_lines(const Mat<S, 3, 3>& D, Vec<S, 3>& l, Vec<S, 3>& m) {
  const Mat<S, 3, 3> B = adjugate(D);  // = -(l x m)(l x m)^T / 4
  int i = 0;
  for (int k = 1; k < 3; ++k) {
    if (std::abs(B(k, k)) > std::abs(B(i, i))) i = k;
  }
  const S scale = squared_norm(D);
  if (!(B(i, i) <= 100 * std::numeric_limits<S>::epsilon() * scale)) return false;
  Mat<S, 3, 3> C = D;
  if (B(i, i) < 0)
    C += hat(Vec<S, 3>(block<3, 1>(B, 0, i) / std::sqrt(-B(i, i))));  // rank one: the outer product of l and m
  int row = 0, col = 0;
  for (int k = 1; k < 9; ++k) {
    if (std::abs(C(k % 3, k / 3)) > std::abs(C(row, col))) row = k % 3, col = k / 3;
  }
  if (!(std::abs(C(row, col)) > 0)) return false;
  l = normalized(Vec<S, 3>(C(row, 0), C(row, 1), C(row, 2)));
  m = normalized(block<3, 1>(C, 0, col));
  return true;
}

/// Newton on (1); false unless the three sides are met.
template <class S>
bool polish(const Vec<S, 3>& cosines, const Vec<S, 3>& sides, Vec<S, 3>& x) {
  constexpr std::array<std::array<int, 2>, 3> pairs{{{1, 2}, {0, 2}, {0, 1}}};
  Vec<S, 3> r;
  for (int iteration = 0; iteration < 4; ++iteration) {
    Mat<S, 3, 3> J = zeros<S, 3, 3>();
    for (int k = 0; k < 3; ++k) {
      const auto [i, j] = pairs[k];
      r[k] = x[i] * x[i] - 2 * cosines[k] * x[i] * x[j] + x[j] * x[j] - sides[k];
      J(k, i) = 2 * (x[i] - cosines[k] * x[j]);
      J(k, j) = 2 * (x[j] - cosines[k] * x[i]);
    }
    if (iteration == 3) break;
    Mat<S, 3, 3> J_inverse;
    if (!invert(J, J_inverse)) break;
    x -= J_inverse * r;
  }
  const S tolerance = std::sqrt(std::numeric_limits<S>::epsilon());
  return max_abs(r) < tolerance * squared_norm(x) && x.minCoeff() > 0;
}

/// Orthonormal frame of a triangle: first side, in plane, normal.
template <class S>
Mat<S, 3, 3> triangle_frame(const Vec<S, 3>& a, const Vec<S, 3>& b, const Vec<S, 3>& c) {
  const Vec<S, 3> x = normalized(b - a), z = normalized(x.cross(c - a));
  return columns<S>(x, z.cross(x), z);
}

}  // namespace p3p_detail

/// Candidates for T_cam_world. Bearings are unit vectors in the camera frame. None for collinear or coincident points.
template <class S>
FixedVector<SE3<S>, 4> p3p(const std::array<Vec<S, 3>, 3>& bearings, const std::array<Vec<S, 3>, 3>& points_world) {
  using Vec3 = Vec<S, 3>;
  using Mat3 = Mat<S, 3, 3>;
  const Vec3 &b1 = bearings[0], &b2 = bearings[1], &b3 = bearings[2];
  const Vec3 &p1 = points_world[0], &p2 = points_world[1], &p3 = points_world[2];
  FixedVector<SE3<S>, 4> out;

  const Vec3 cosines(dot(b2, b3), dot(b1, b3), dot(b1, b2));  // of the sides 23, 13, 12
  Vec3 sides(squared_norm(p2 - p3), squared_norm(p1 - p3), squared_norm(p1 - p2));
  const S size2 = sides.maxCoeff();
  const S eps = std::numeric_limits<S>::epsilon();
  const S doubled_area = norm((p2 - p1).cross(p3 - p1));
  if (!(doubled_area > 100 * eps * size2) || !(cosines.maxCoeff() < 1 - 4 * eps)) return out;
  sides /= size2;

  const auto [a23, a13, a12] = std::array<S, 3>{sides[0], sides[1], sides[2]};
  Mat3 D1, D2;  // (2)
  D1 << a23, -a23 * cosines[2], 0, -a23 * cosines[2], a23 - a12, a12 * cosines[0], 0, a12 * cosines[0], -a12;
  D2 << a23, 0, -a23 * cosines[1], 0, -a13, a13 * cosines[0], -a23 * cosines[1], a13 * cosines[0], a23 - a13;
  const Mat3 adjugate1 = p3p_detail::adjugate(D1), adjugate2 = p3p_detail::adjugate(D2);
  S c0 = dot(column(D1, 0), column(adjugate1, 0)), c1 = dot(adjugate1, D2);
  S c3 = dot(column(D2, 0), column(adjugate2, 0)), c2 = dot(adjugate2, D1);
  if (std::abs(c0) > std::abs(c3)) {  // (3) in 1/g: the leading coefficient is the larger one
    std::swap(D1, D2);
    std::swap(c0, c3);
    std::swap(c1, c2);
  }
  const S g = c3 != 0 ? p3p_detail::isolated_root(c2 / c3, c1 / c3, c0 / c3) : S(0);

  std::array<Vec3, 2> lines;
  if (!p3p_detail::split_lines(Mat3(D1 + g * D2), lines[0], lines[1])) return out;
  const Mat3& D = std::abs(g) > 1 ? D1 : D2;  // on the lines D1 = -g D2: the larger of the two
  const Mat3 F_world = p3p_detail::triangle_frame(p1, p2, p3);
  for (const Vec3& line : lines) {
    const Vec3 u = unit_orthogonal(line), v = line.cross(u);  // x = s u + t v
    const S uu = dot(u, D * u), uv = dot(u, D * v), vv = dot(v, D * v);
    const S discriminant = uv * uv - uu * vv;
    if (!(discriminant > -100 * eps * (uv * uv + uu * uu + vv * vv))) continue;
    const S w = -(uv + std::copysign(std::sqrt(std::max(discriminant, S(0))), uv));
    for (Vec3 x : {Vec3(w * u + uu * v), Vec3(vv * u + w * v)}) {  // (s, t) = (w, uu) and (vv, w)
      if (x.sum() < 0) x = -x;
      if (!(x.minCoeff() > 0)) continue;
      x /= norm(x);
      const S metric = 2 * (1 - cosines[0] * x[1] * x[2] - cosines[1] * x[0] * x[2] - cosines[2] * x[0] * x[1]);
      x *= std::sqrt(sides.sum() / metric);  // sum of (1)
      if (!p3p_detail::polish(cosines, sides, x)) continue;
      x *= std::sqrt(size2);
      const Mat3 F_cam = p3p_detail::triangle_frame(Vec3(x[0] * b1), Vec3(x[1] * b2), Vec3(x[2] * b3));
      const SO3<S> R = SO3<S>::from_matrix(product_transposed(F_cam, F_world));
      const SE3<S> T_cam_world(R, (x[0] * b1 + x[1] * b2 + x[2] * b3 - (R * p1 + R * p2 + R * p3)) / 3);
      if (T_cam_world.is_finite()) out.push_back(T_cam_world);
    }
  }
  return out;
}

}  // namespace plumbline
