#pragma once
/// Camera pose with a known gravity direction, from points and lines: heading and translation.  docs/math/geometry.md 9
///
///   R_cam_world = R_t Rz(psi),   R_t e3 = u, the up direction in the camera frame (z of the world is up)      (32)
///   k . (R_cam_world X + t) = 0,   h = R_t^T k:
///   [k^T, h1 X1 + h2 X2, h2 X1 - h1 X2, h3 X3] (t, cos psi, sin psi, 1) = 0                                   (33)
///   point: two k across its bearing;   line: k = normal of its plane, for two points X of the line
/// An orthogonal triangularization eliminates t. Of two points, or a point and a line, one row remains:
///   a cos psi + b sin psi + g = 0:   at most two solutions                                                    (34)
/// Of more features, |B (cos psi, sin psi) + g|^2 is minimized over the circle.                                (35)
/// Two lines are no minimal sample: they leave t free along the cross product of their normals.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class S>
struct GravityPosePoint {
  Vec<S, 3> bearing;  ///< unit, camera frame
  Vec<S, 3> p_world;  ///< [m]
};

template <class S>
struct GravityPoseLine {
  Vec<S, 3> normal;                       ///< unit, camera frame, of the plane through the observed line; either sign
  std::array<Vec<S, 3>, 2> points_world;  ///< any two points of the line [m]
};

template <class S>
struct GravityPoseFit {
  bool valid = false;
  SE3<S> T_cam_world;
};

namespace gravity_pose_detail {

/// Rows (33), triangularized row by row (Givens), of coordinates about the center of the points in units of their size.
template <class S>
class Rows {
 public:
  Rows(const Vec<S, 3>& up_cam, std::span<const GravityPosePoint<S>> points, std::span<const GravityPoseLine<S>> lines)
      : points_(points), lines_(lines) {
    const Vec<S, 3> z = normalized(up_cam), x = unit_orthogonal(z);
    set_block(R_t_, 0, 0, x);
    set_block(R_t_, 0, 1, Vec<S, 3>(z.cross(x)));
    set_block(R_t_, 0, 2, z);
    int count = 0;
    S farthest = S(0), squared_size = S(0);
    set_zero(center_);
    for_each_point([&](const Vec<S, 3>& p) {
      center_ += p;
      ++count;
    });
    if (count == 0) return;
    center_ /= S(count);
    for_each_point([&](const Vec<S, 3>& p) {
      squared_size = std::max(squared_size, squared_norm(Vec<S, 3>(p - center_)));
      farthest = std::max(farthest, max_abs(p));
      finite_ = finite_ && all_finite(p);
    });
    size_ = std::sqrt(squared_size);
    finite_ = finite_ && std::abs(squared_norm(up_cam) - S(1)) < S(1e-2) && std::isfinite(squared_size);
    spread_ = finite_ && size_ > 100 * epsilon * farthest;
  }

  /// False for coincident points, and for numbers that are not finite. A feature weighs 1/distance from the camera of
  /// `pose`: a row is an angle times this distance.
  bool triangularize(const SE3<S>* pose = nullptr) {
    for (auto& row : R_) row.fill(S(0));
    if (!spread_) return false;
    const auto weight = [&](const Vec<S, 3>& p) {
      return pose ? size_ / std::max(norm(Vec<S, 3>(*pose * p)), epsilon * size_) : S(1);
    };
    for (const GravityPosePoint<S>& point : points_) {
      const Vec<S, 3> k = unit_orthogonal(point.bearing);
      const S w = weight(point.p_world);
      add(Vec<S, 3>(w * k), point.p_world);
      add(Vec<S, 3>(w * normalized(Vec<S, 3>(point.bearing.cross(k)))), point.p_world);
    }
    for (const GravityPoseLine<S>& line : lines_) {
      for (const Vec<S, 3>& p : line.points_world) add(Vec<S, 3>(weight(p) * normalized(line.normal)), p);
    }
    const S largest = std::max({std::abs(R_[0][0]), std::abs(R_[1][1]), std::abs(R_[2][2])});
    const S smallest = std::min({std::abs(R_[0][0]), std::abs(R_[1][1]), std::abs(R_[2][2])});
    if (!(smallest > std::sqrt(epsilon) * largest)) return false;  // t is not determined; NaN
    for (const auto& row : R_) {
      if (!std::all_of(row.begin(), row.end(), [](S number) { return std::isfinite(number); })) return false;
    }
    return true;
  }

  /// (34), for four rows.
  FixedVector<SE3<S>, 2> minimal() const {
    FixedVector<SE3<S>, 2> out;
    const S a = R_[3][3], b = R_[3][4], g = R_[3][5], rho = std::sqrt(a * a + b * b);
    if (!(rho > std::sqrt(epsilon))) return out;  // psi is not determined
    const S distance = -g / rho, across2 = S(1) - distance * distance;
    if (!(across2 > S(-100) * epsilon)) return out;
    const S middle = elementary::atan2(b, a), half = elementary::atan2(std::sqrt(std::max(across2, S(0))), distance);
    offer(middle + half, out);
    if (half > S(0)) offer(middle - half, out);
    return out;
  }

  /// (35): of its minima the one with fewer points behind the camera, then the lower one.
  GravityPoseFit<S> least_squares() const {
    constexpr int samples = 16;
    constexpr S step = S(2 * 3.14159265358979323846 / samples);
    std::array<S, samples> values;
    for (int k = 0; k < samples; ++k) values[std::size_t(k)] = at(step * S(k)).value;
    GravityPoseFit<S> best;
    int fewest_behind = 0;
    S lowest = S(0);
    for (int k = 0; k < samples; ++k) {
      const S here = values[std::size_t(k)];
      if (values[std::size_t((k + samples - 1) % samples)] < here || values[std::size_t((k + 1) % samples)] < here) {
        continue;
      }
      S psi = step * S(k);
      for (int iteration = 0; iteration < 8; ++iteration) {  // Newton, within the samples
        const Value f = at(psi);
        psi += f.curvature > S(0) ? std::clamp(-f.slope / f.curvature, -step / 2, step / 2) : S(0);
      }
      const Value f = at(psi);
      if (!(f.curvature > epsilon)) continue;  // psi is not determined
      const SE3<S> T = pose(psi);
      const int behind = int(std::count_if(points_.begin(), points_.end(), [&T](const GravityPosePoint<S>& point) {
        return !(dot(point.bearing, Vec<S, 3>(T * point.p_world)) > S(0));
      }));
      if (!T.is_finite() ||
          (best.valid && (behind > fewest_behind || (behind == fewest_behind && f.value >= lowest)))) {
        continue;
      }
      best = {true, T};
      fewest_behind = behind;
      lowest = f.value;
    }
    return best;
  }

 private:
  static constexpr S epsilon = std::numeric_limits<S>::epsilon();
  struct Value {
    S value, slope, curvature;  ///< of half the squares (35) by psi
  };

  template <class Visit>
  void for_each_point(Visit&& visit) const {
    for (const GravityPosePoint<S>& point : points_) visit(point.p_world);
    for (const GravityPoseLine<S>& line : lines_) {
      for (const Vec<S, 3>& p : line.points_world) visit(p);
    }
  }
  void add(const Vec<S, 3>& k, const Vec<S, 3>& p_world) {  // (33)
    const Vec<S, 3> X = (p_world - center_) / size_;
    const Vec<S, 3> h(dot(k, column(R_t_, 0)), dot(k, column(R_t_, 1)), dot(k, column(R_t_, 2)));
    std::array<S, 6> row{k[0], k[1], k[2], h[0] * X[0] + h[1] * X[1], h[1] * X[0] - h[0] * X[1], h[2] * X[2]};
    for (std::size_t i = 0; i < 6; ++i) {
      if (row[i] == S(0)) continue;
      std::array<S, 6>& pivot = R_[i];
      const S length = std::sqrt(pivot[i] * pivot[i] + row[i] * row[i]), c = pivot[i] / length, s = row[i] / length;
      for (std::size_t j = i; j < 6; ++j) {
        const S upper = c * pivot[j] + s * row[j];
        row[j] = c * row[j] - s * pivot[j];
        pivot[j] = upper;
      }
    }
  }
  Value at(S psi) const {
    const S c = elementary::cos(psi), s = elementary::sin(psi);
    Value out{S(0), S(0), S(0)};
    for (std::size_t i = 3; i < 6; ++i) {
      const S a = R_[i][3], b = R_[i][4], r = a * c + b * s + R_[i][5], J = b * c - a * s;
      out.value += r * r / 2;
      out.slope += r * J;
      out.curvature += J * J - r * (a * c + b * s);
    }
    return out;
  }
  SE3<S> pose(S psi) const {
    const S c = elementary::cos(psi), s = elementary::sin(psi);
    Vec<S, 3> t;
    for (int i = 2; i >= 0; --i) {
      const std::array<S, 6>& row = R_[std::size_t(i)];
      S sum = row[3] * c + row[4] * s + row[5];
      for (int j = i + 1; j < 3; ++j) sum += row[std::size_t(j)] * t[j];
      t[i] = -sum / row[std::size_t(i)];
    }
    const SO3<S> R = SO3<S>::from_matrix(R_t_) * SO3<S>::exp({S(0), S(0), psi});
    return SE3<S>(R, Vec<S, 3>(size_ * t - R * center_));
  }
  void offer(S psi, FixedVector<SE3<S>, 2>& out) const {
    const SE3<S> T = pose(psi);
    bool in_front = T.is_finite();
    for (const GravityPosePoint<S>& point : points_) {
      in_front = in_front && dot(point.bearing, Vec<S, 3>(T * point.p_world)) > S(0);
    }
    if (in_front) out.push_back(T);
  }

  std::span<const GravityPosePoint<S>> points_;
  std::span<const GravityPoseLine<S>> lines_;
  Mat<S, 3, 3> R_t_;
  Vec<S, 3> center_;
  S size_ = S(0);
  bool finite_ = true, spread_ = false;
  std::array<std::array<S, 6>, 6> R_;  ///< upper triangular, columns t, cos psi, sin psi, 1
};

}  // namespace gravity_pose_detail

/// Candidates for T_cam_world with both points in front; up_cam is unit. None for points above one another, coincident
/// points, equal bearings, and bearings that are both horizontal.
template <class S>
FixedVector<SE3<S>, 2> gravity_pose(const Vec<S, 3>& up_cam, const std::array<GravityPosePoint<S>, 2>& points) {
  gravity_pose_detail::Rows<S> rows(up_cam, points, {});
  return rows.triangularize() ? rows.minimal() : FixedVector<SE3<S>, 2>();
}
/// The same of a point and a line. None for a line parallel to gravity or through the point, and a point seen on it.
template <class S>
FixedVector<SE3<S>, 2> gravity_pose(const Vec<S, 3>& up_cam, const GravityPosePoint<S>& point,
                                    const GravityPoseLine<S>& line) {
  gravity_pose_detail::Rows<S> rows(up_cam, {&point, 1}, {&line, 1});
  return rows.triangularize() ? rows.minimal() : FixedVector<SE3<S>, 2>();
}

/// The pose of all rows of three or more features, solved twice: the second time with weights 1/distance.
template <class S>
GravityPoseFit<S> gravity_pose_least_squares(const Vec<S, 3>& up_cam, std::span<const GravityPosePoint<S>> points,
                                             std::span<const GravityPoseLine<S>> lines = {}) {
  gravity_pose_detail::Rows<S> rows(up_cam, points, lines);
  if (points.size() + lines.size() < 3 || !rows.triangularize()) return {};
  const GravityPoseFit<S> first = rows.least_squares();
  return first.valid && rows.triangularize(&first.T_cam_world) ? rows.least_squares() : GravityPoseFit<S>{};
}

}  // namespace plumbline
