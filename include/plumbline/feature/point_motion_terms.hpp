#pragma once
/// What the points say about the pose of one frame, their map being given.                 docs/math/point.md
///
/// A landmark's own uncertainty widens its residual along the direction in which it would move the observation:
///   Sigma_uv = (L^T L)^-1 + J_uv_lambda J_uv_lambda^T sigma_lambda^2,  Sigma_z = sigma_z^2 + (J_z_lambda
///   sigma_lambda)^2 Sigma_uv^-1/2 = (I - c j j^T / |j|^2) L,  j = L J_uv_lambda sigma_lambda,  c = 1 - 1/sqrt(1 +
///   |j|^2)    (10)
/// so that landmarks just found from one noisy depth do not outvote those seen for long.
///
/// The readout time of a rolling shutter moves observation and anchor (docs/math/rolling_shutter.md):
///   dr_uv/d readout = J_uv_X dX/d readout - duv/d readout,   dX/d readout = R_wa (dbearing/d readout) / lambda

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/point_landmark.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <SensorRig Sensors, class Map>
class PointMotionTerms {
 public:
  using S = typename Sensors::Scalar;
  using Landmark = typename Map::Landmark;
  using Window = typename Map::Window;

  /// All located landmarks that the latest frame sees.
  void collect(const View<Sensors>& view, const Map& map, const Window& window) {
    points_.clear();
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      if (!landmark.current.valid || !landmark.located) continue;
      const SE3<S> T_world_cam = window[landmark.anchor].pose.value() * view.T_body_cam;
      const Vec<S, 3> p_cam = landmark.p_anchor_cam();
      const Vec<S, 3> sigma_cam = p_cam * (landmark.sigma_inverse_range / landmark.inverse_range);
      const Vec<S, 3> slope_cam = landmark.bearing_slope / landmark.inverse_range;
      points_.push_back({static_cast<int>(i), T_world_cam * p_cam, T_world_cam.rotation() * sigma_cam,
                         T_world_cam.rotation() * slope_cam, landmark.current});
    }
  }

  std::size_t size() const { return points_.size(); }

  /// Adds the weighted rows at a pose; of pose and readout time where the system has seven parameters.
  template <int Dim>
  void accumulate(const Sensors& rig, const BodyView<S>& view, DenseNormalEquations<S, Dim>& system) const {
    static_assert(Dim == 6 || Dim == 7);
    for (const Point& point : points_) {
      const Whitened whitened = whiten(rig, view, point);
      if (!whitened.valid) continue;
      const S s = whitened.r_uv.squaredNorm();
      system.add(Mat<S, 2, Dim>(whitened.J_uv.template leftCols<Dim>()), whitened.r_uv, pixel_loss_.weight(s));
      system.add_cost(pixel_loss_.rho(s));
      if (!whitened.has_depth) continue;
      const S s_z = whitened.r_z.squaredNorm();
      system.add(Mat<S, 1, Dim>(whitened.J_z.template leftCols<Dim>()), whitened.r_z, depth_loss_.weight(s_z));
      system.add_cost(depth_loss_.rho(s_z));
    }
  }

  /// Takes observations beyond `chi2` (two degrees of freedom) out of the frame; returns how many stay. The frame's own
  /// scale is the median of all errors: blur and rolling shutter make all of them larger, and then all weigh less.
  int gate(const Sensors& rig, Map& map, const BodyView<S>& view, S chi2) {
    errors_.clear();
    for (const Point& point : points_) {
      const Whitened whitened = whiten(rig, view, point);
      errors_.push_back(whitened.valid ? whitened.r_uv.squaredNorm() : std::numeric_limits<S>::infinity());
    }
    sorted_ = errors_;
    const std::size_t middle = sorted_.size() / 2;
    std::nth_element(sorted_.begin(), sorted_.begin() + middle, sorted_.end());
    const S scale2 = sorted_.empty() ? S(1) : std::max(S(1), sorted_[middle] / S(1.386));  // median of chi2(2)
    int inliers = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      if (errors_[i] < chi2 * scale2) {
        ++inliers;
        map.scale_sigma(points_[i].index, float(std::sqrt(scale2)));
      } else {
        map.reject_current(points_[i].index);
      }
    }
    return inliers;
  }

 private:
  struct Point {
    int index;
    Vec<S, 3> p_world;
    Vec<S, 3> sigma_world;  ///< one standard deviation of the inverse range, as a move in the world
    Vec<S, 3> slope_world;  ///< d p_world / d readout [m/s]
    PointObservation<S> seen;
  };
  struct Whitened {
    bool valid, has_depth;
    Vec<S, 2> r_uv;
    Mat<S, 2, 7> J_uv;  ///< pose, readout
    Vec<S, 1> r_z;
    Mat<S, 1, 7> J_z;
  };

  Whitened whiten(const Sensors& rig, const BodyView<S>& view, const Point& point) const {
    Whitened out;
    const auto pixel = PointReprojection<typename Sensors::Camera>{point.seen.uv.template cast<S>()}.linearize(
        rig.vision.camera, view, point.p_world);
    out.valid = pixel.valid;
    if (!out.valid) return out;
    const Mat<S, 2, 2> L = point.seen.L.template cast<S>();
    const Vec<S, 2> j = L * (pixel.J_r_point * point.sigma_world);
    const S jj = j.squaredNorm();
    Mat<S, 2, 2> W = L;
    if (jj > S(1e-12)) {
      const S shrink = (S(1) - S(1) / std::sqrt(S(1) + jj)) / jj;
      for (int c = 0; c < 2; ++c) {
        const S along = shrink * (j[0] * L(0, c) + j[1] * L(1, c));
        for (int i = 0; i < 2; ++i) W(i, c) -= along * j[i];  // (10)
      }
    }
    const Vec<S, 2> slope = pixel.J_r_point * point.slope_world;
    const S u = slope[0] - S(point.seen.uv_slope[0]), v = slope[1] - S(point.seen.uv_slope[1]);
    for (int i = 0; i < 2; ++i) {
      out.r_uv[i] = W(i, 0) * pixel.r[0] + W(i, 1) * pixel.r[1];
      for (int c = 0; c < 6; ++c) out.J_uv(i, c) = W(i, 0) * pixel.J_r_pose(0, c) + W(i, 1) * pixel.J_r_pose(1, c);
      out.J_uv(i, 6) = W(i, 0) * u + W(i, 1) * v;
    }
    out.has_depth = point.seen.depth.valid;
    if (!out.has_depth) return out;
    const auto depth = PointInverseDepth<S>{point.seen.depth.value}.linearize(view, point.p_world);
    out.has_depth = depth.valid;
    if (!out.has_depth) return out;
    S j_z = S(0), slope_z = S(0);
    for (int c = 0; c < 3; ++c) {
      j_z += depth.J_r_point(0, c) * point.sigma_world[c];
      slope_z += depth.J_r_point(0, c) * point.slope_world[c];
    }
    const S w = S(1) / std::sqrt(point.seen.depth.sigma * point.seen.depth.sigma + j_z * j_z);
    out.r_z[0] = w * depth.r[0];
    for (int c = 0; c < 6; ++c) out.J_z(0, c) = w * depth.J_r_pose(0, c);
    out.J_z(0, 6) = w * slope_z;
    return out;
  }

  Huber<S> pixel_loss_{S(2.45)};  ///< sqrt(chi2_95_2dof)
  Huber<S> depth_loss_{S(1.345)};
  FixedVector<Point, Map::Landmarks::capacity()> points_;
  FixedVector<S, Map::Landmarks::capacity()> errors_, sorted_;
};

}  // namespace plumbline
