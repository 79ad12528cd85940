#pragma once
// Points, and points in space that lie on segments of the image: their rows, and the shape of all of them.

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline::test {

/// A known point that lies on an observed segment, somewhere.
template <class S>
struct PointOnSegment {
  Vec<S, 3> normal;   ///< unit, of the plane through the camera and the segment, camera frame
  Vec<S, 3> p_world;  ///< [m]
  S sigma_rad;        ///< angular noise of the point's distance to the plane
};

template <class S>
bool is_usable(const Vec<S, 3>& direction, const Vec<S, 3>& p_world, S sigma_rad) {
  return all_finite(direction) && all_finite(p_world) && sigma_rad > S(0) && std::isfinite(sigma_rad);
}

template <class S>
struct LineAssistedRows {
  std::span<const PoseCorrespondence<S>> points;
  std::span<const PointOnSegment<S>> on_segments;

  /// visit(p_world) for all that can be used.
  void for_each(auto&& visit) const {
    for (const auto& c : points)
      if (is_usable(c.bearing, c.p_world, c.sigma_rad)) visit(c.p_world);
    for (const auto& c : on_segments)
      if (is_usable(c.normal, c.p_world, c.sigma_rad)) visit(c.p_world);
  }
  /// visit(normal, p_world, sigma_rad) for each row.
  void for_each_row(auto&& visit) const {
    for (const auto& c : points) {
      if (!is_usable(c.bearing, c.p_world, c.sigma_rad)) continue;
      const Vec<S, 3> u = unit_orthogonal(c.bearing);
      visit(u, c.p_world, c.sigma_rad);
      visit(Vec<S, 3>(c.bearing.cross(u)), c.p_world, c.sigma_rad);
    }
    for (const auto& c : on_segments)
      if (is_usable(c.normal, c.p_world, c.sigma_rad)) visit(c.normal, c.p_world, c.sigma_rad);
  }
  /// Sum of squared angles by their sigmas; infinite where a point is not in front.
  S cost(const SE3<S>& T_cam_world) const {
    for (const auto& c : points) {
      if (!is_usable(c.bearing, c.p_world, c.sigma_rad)) continue;
      if (!(dot(c.bearing, Vec<S, 3>(T_cam_world * c.p_world)) > S(0))) return std::numeric_limits<S>::infinity();
    }
    S sum = S(0);
    for_each_row([&](const Vec<S, 3>& normal, const Vec<S, 3>& p_world, S sigma_rad) {
      const Vec<S, 3> p = T_cam_world * p_world;
      const S e = dot(normal, p) / (norm(p) * sigma_rad);
      sum += e * e;
    });
    return sum;
  }
};

/// Mean and principal axes; the deviations are in descending order.
template <class S>
struct RowShape {
  int count = 0, rows = 0;
  Vec<S, 3> mean = zeros<S, 3>();
  Vec<S, 3> deviation = zeros<S, 3>();
  Mat<S, 3, 3> axes = zeros<S, 3, 3>();

  explicit RowShape(const LineAssistedRows<S>& problem) {
    Mat<S, 3, 3> moment = zeros<S, 3, 3>();
    problem.for_each([&](const Vec<S, 3>& p) {
      ++count;
      const Vec<S, 3> d = p - mean;
      mean += d / S(count);
      const Vec<S, 3> after = p - mean;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) moment(i, j) += (d[i] * after[j] + after[i] * d[j]) / S(2);
    });
    problem.for_each_row([&](const Vec<S, 3>&, const Vec<S, 3>&, S) { ++rows; });
    if (count == 0 || !all_finite(moment)) return;
    const Eigen::SelfAdjointEigenSolver<Mat<S, 3, 3>> eigen(moment);
    for (int k = 0; k < 3; ++k) {
      deviation[k] = std::sqrt(std::max(eigen.eigenvalues()[2 - k], S(0)) / S(count));
      set_block(axes, 0, k, Vec<S, 3>(eigen.eigenvectors().col(2 - k)));
    }
  }
};

}  // namespace plumbline::test
