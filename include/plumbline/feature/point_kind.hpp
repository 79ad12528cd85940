#pragma once
/// Feature kind: points, each an inverse range along the unit bearing of its first observation (the anchor).
///                                                                      docs/math/point.md, docs/math/window.md
/// Terms in the window:
///   1/2 rho(|L r_uv|^2) + 1/2 rho(r_z^2 / sigma_z^2)
/// over reprojections in every frame except the anchor, and measured inverse depths in every frame.
///
/// Its rows of pose refinement are those of point_in_world.hpp.
///
/// With a rolling shutter observation and bearing depend on the readout time (docs/math/rolling_shutter.md):
///   dr_uv/d readout = J_uv_P R_ja db_a/d readout - duv/d readout                                               (3)

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/feature/feature_kind.hpp"
#include "plumbline/feature/point_in_world.hpp"
#include "plumbline/feature/point_observation.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/whitened_rows.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/tracking/surface_slant.hpp"

namespace plumbline {

template <SensorRig SensorsT, template <class> class Loss = Huber>
struct PointKind {
  using Sensors = SensorsT;
  using Scalar = typename Sensors::Scalar;
  using S = Scalar;
  using Camera = typename Sensors::Camera;
  using Observation = PointObservation<S, Sensors::has_depth, Sensors::rolls>;
  using Place = Vec<float, 2>;  ///< in the image [px]
  using Appearance = PointAppearance;
  static constexpr int dim = 1;  ///< lambda
  static constexpr int rows_per_view = Sensors::has_depth ? 3 : 2, damping_rows = 0;
  /// Limits of the inverse range [1/m]; geometry: 5 cm to 1 km.
  static constexpr S lambda_min = S(1e-3), lambda_max = S(20);
  static_assert(RobustLoss<Loss<S>>, "plumbline: this is no robust kernel, see solver/robust_loss.hpp");
  static constexpr Loss<S> pixel_loss = loss_for<Loss, S, 2>, depth_loss = loss_for<Loss, S, 1>;

  struct Geometry {
    Vec<S, 3> bearing = Vec<S, 3>(0, 0, 1);  ///< unit, in the anchor camera
    S inverse_range = S(0);                  ///< lambda [1/m]
    S sigma_inverse_range = S(0);            ///< its sigma, the poses fixed [1/m]
    /// Of the bearing by the readout time.
    [[no_unique_address]] Present<RowDerivative<S, 3>, Sensors::rolls> derivative;
  };

  // -------------------------------------------------------------------------------------------------- geometry

  /// The point in the camera of the anchor [m].
  static Vec<S, 3> middle(const Geometry& point) { return point.bearing / point.inverse_range; }
  static S inverse_range(const Geometry& point) { return point.inverse_range; }
  static void rescale(Geometry& point, S scale) {
    point.inverse_range /= scale;
    point.sigma_inverse_range /= scale;
    RowDerivative<S, 3> derivative = point.derivative.get();
    derivative.rescale(scale);
    point.derivative.set(derivative);
  }
  static void change_readout(Geometry& point, const Observation&, S change_s) {
    point.bearing = normalized(point.bearing + change_s * point.derivative.get().by_readout());
  }
  /// Corrects bearing and observation of the anchor for the range of the point, see row_ranges.hpp.
  static void set_range_in_anchor(Geometry& point, Observation& seen, S readout_s) {
    seen.set_inverse_range(point.inverse_range, readout_s);
    RowDerivative<S, 3> derivative = point.derivative.get();
    point.bearing = normalized(point.bearing + derivative.set_inverse_range(point.inverse_range, readout_s));
    point.derivative.set(derivative);
  }
  /// The same for the observation by another frame.
  static void set_range(const Geometry& point, Observation& seen, const SE3<S>& T_cam_anchor, S readout_s) {
    const S range = norm(T_cam_anchor * middle(point));
    if (range * lambda_max > S(1)) seen.set_inverse_range(S(1) / range, readout_s);
  }
  /// Corrects bearing and observation for another motion of the anchor's camera during its readout, see row_motion.hpp.
  static void set_motion_in_anchor(Geometry& point, Observation& seen, const auto& shutter, S readout_s) {
    seen.set_motion(shutter, readout_s);
    RowDerivative<S, 3> derivative = point.derivative.get();
    const RowDerivative<S, 3> moved =
        shutter.bearing_derivative(cast_to<S>(seen.pixel), point.bearing, derivative.inverse_range);
    point.bearing = normalized(point.bearing + derivative.set_motion(moved, readout_s));
    point.derivative.set(derivative);
  }
  static double motion_px(const Observation& then, const Observation& now) { return norm(now.pixel - then.pixel); }

  static void step(Geometry& point, const Vec<S, dim>& d) {
    if (d[0] != S(0)) point.inverse_range = std::clamp(point.inverse_range + d[0], lambda_min, lambda_max);
  }
  /// After convergence: sets the covariance, the poses fixed; null without one. Always true: points are not removed.
  static bool set_covariance(Geometry& point, const Observation&, const Mat<S, dim, dim>* covariance) {
    if (covariance) point.sigma_inverse_range = std::sqrt((*covariance)(0, 0));
    return true;
  }

  // --------------------------------------------------------------------------------------------- in the window

  using InAnchor = Geometry;
  using Linearized = Geometry;

  /// Adds the row of the depth measured by the anchor, or its derivative by the readout time; returns the cost.
  template <class Rows>
  static double add_anchor(const InAnchor& point, const Observation& seen, Rows& rows) {
    const InverseDepth<S>& depth = seen.depth.get();
    if (!depth.valid) return 0;
    const S r = anchor_depth_error(point, depth), w = std::sqrt(depth_loss.weight(r * r));
    const S by_lambda = w / (depth.sigma * point.bearing.z());
    if constexpr (TakesDerivatives<Rows>) {
      const S z_derivative = point.derivative.get().by_readout().z();
      rows.add_derivatives(Vec<S, 1>(-by_lambda * z_derivative * point.inverse_range / point.bearing.z()));
    } else {
      rows.template add<1>(Mat<S, 1, 1>(by_lambda), Vec<S, 1>(w * r));
    }
    return double(depth_loss.rho(r * r)) / 2;
  }
  /// No rows: the pixel in the anchor defines the bearing and has no residual.
  template <class Rows>
  static void add_anchor_pixels(const InAnchor&, const Observation&, Rows&) {}

  /// Adds the weighted rows of the observation by the frame in `slot`, not the anchor, or their derivatives by the
  /// readout time; returns the cost.
  template <class Rows>
  static double add_view(const Sensors& rig, const InAnchor& point, const Observation& seen,
                         const RelativeView<S>& view, int slot, Rows& rows) {
    const S lambda = point.inverse_range;
    const Vec<S, 3> P = view.scaled_point(point.bearing, lambda);
    const auto pixel = InverseDepthReprojection<Camera>{cast_to<S>(seen.uv)}.linearize(rig.vision.camera, P);
    if (!pixel.valid) return invalid_cost;
    const Vec<S, 2> r = whitened(seen, pixel.r);
    const S w = std::sqrt(pixel_loss.weight(squared_norm(r)));
    Mat<S, rows_per_view, 3> J_P;
    Vec<S, rows_per_view> J_lambda, weighted;
    for (int k = 0; k < 2; ++k) {
      const S wL0 = w * S(seen.L(k, 0)), wL1 = w * S(seen.L(k, 1));
      for (int c = 0; c < 3; ++c) J_P(k, c) = wL0 * pixel.J_r_P(0, c) + wL1 * pixel.J_r_P(1, c);
      weighted[k] = w * r[k];
    }
    double cost = double(pixel_loss.rho(squared_norm(r))) / 2;
    bool has_depth = false;
    if constexpr (Sensors::has_depth) {
      const InverseDepth<S>& measured = seen.depth.get();
      const auto depth = InverseDepthMeasurement<S>{measured.value}.linearize(P, lambda);
      has_depth = measured.valid && depth.valid;
      if (has_depth) {
        const S r_z = depth.r[0] / measured.sigma, w_z = std::sqrt(depth_loss.weight(r_z * r_z)) / measured.sigma;
        for (int c = 0; c < 3; ++c) J_P(2, c) = w_z * depth.J_r_P(0, c);
        J_lambda[2] = w_z * depth.J_r_lambda[0];
        weighted[2] = w_z * depth.r[0];
        cost += double(depth_loss.rho(r_z * r_z)) / 2;
      }
    }
    if constexpr (TakesDerivatives<Rows>) {
      const Vec<S, 2> uv_derivative = cast_to<S>(seen.derivative.get().by_readout());
      const Vec<S, 3> P_derivative = view.R_target_anchor() * point.derivative.get().by_readout();
      Vec<S, rows_per_view> derivatives = J_P * P_derivative;  // (3)
      for (int k = 0; k < 2; ++k)
        derivatives[k] -= w * (S(seen.L(k, 0)) * uv_derivative[0] + S(seen.L(k, 1)) * uv_derivative[1]);
      has_depth ? rows.add_derivatives(derivatives) : rows.add_derivatives(segment<2>(derivatives, 0));
    } else {
      for (int k = 0; k < rows_per_view; ++k) {  // chained once for all rows that share P~
        if (k >= 2 && !has_depth) break;
        S by_lambda = S(0);
        for (int c = 0; c < 3; ++c) by_lambda += J_P(k, c) * view.t_target_anchor()[c];
        J_lambda[k] = (k < 2 ? S(0) : J_lambda[k]) + by_lambda;
      }
      if (has_depth) {
        add_top<rows_per_view>(view, slot, P, lambda, J_P, J_lambda, weighted, rows);
      } else {
        add_top<2>(view, slot, P, lambda, J_P, J_lambda, weighted, rows);
      }
    }
    return cost;
  }

  template <class Rows>
  static void add_damping(Rows&) {}

  static double cost_in_anchor(const InAnchor& point, const Observation& seen) {
    const InverseDepth<S>& depth = seen.depth.get();
    if (!depth.valid) return 0;
    const S r = anchor_depth_error(point, depth);
    return double(depth_loss.rho(r * r)) / 2;
  }
  static double cost(const Sensors& rig, const InAnchor& point, const Observation& seen, const RelativeView<S>& view) {
    const Errors errors = errors_of(rig, point, seen, view);
    if (!errors.valid) return invalid_cost;
    return double(pixel_loss.rho(squared_norm(errors.pixel)) + depth_loss.rho(errors.depth * errors.depth)) / 2;
  }

  /// Rejects outlier observations; none in the anchor.
  static void reject_outliers_in_anchor(const InAnchor&, Observation&) {}
  static void reject_outliers(const Sensors& rig, const InAnchor& point, Observation& seen,
                              const RelativeView<S>& view) {
    const Errors errors = errors_of(rig, point, seen, view);
    seen.valid = errors.valid && squared_norm(errors.pixel) < drop_chi2;
  }

  // --------------------------------------------------------------------------------------------- in one frame

  using InWorld = PointInWorld<Sensors>;
  static InWorld in_world(const Geometry& point, const Observation& current, const SE3<S>& T_world_anchor) {
    const Vec<S, 3> p_cam = middle(point);
    const Vec<S, 3> sigma_cam = p_cam * (point.sigma_inverse_range / point.inverse_range);
    return {T_world_anchor * p_cam, T_world_anchor.rotation() * sigma_cam, current};
  }
  static WhitenedRows<S, 2> pixel_rows(const Sensors& rig, const BodyView<S>& view, const InWorld& point) {
    return point.pixel_rows(rig, view);
  }
  static double error_px(const Sensors& rig, const BodyView<S>& view, const InWorld& point) {
    return point.error_px(rig, view);
  }
  static constexpr int depth_dim = 1;
  static bool has_depth(const InWorld& point) { return point.has_depth(); }
  static WhitenedRows<S, depth_dim> depth_rows(const BodyView<S>& view, const InWorld& point) {
    return point.depth_rows(view);
  }

 private:
  /// Of an observation that is not valid at the current state; numerics: above the cost of any inlier.
  static constexpr double invalid_cost = 100;
  /// Whitened squared error of an outlier; chi-square quantile 99.9996 %, 2 degrees of freedom.
  static constexpr S drop_chi2 = S(25);

  /// Whitened errors of one observation by a frame other than the anchor.
  struct Errors {
    bool valid = false;
    Vec<S, 2> pixel = zeros<S, 2>();
    S depth = S(0);  ///< zero without a measurement
  };

  static Vec<S, 2> whitened(const Observation& seen, const Vec<S, 2>& r) {
    return {S(seen.L(0, 0)) * r[0] + S(seen.L(0, 1)) * r[1], S(seen.L(1, 0)) * r[0] + S(seen.L(1, 1)) * r[1]};
  }
  static S anchor_depth_error(const InAnchor& point, const InverseDepth<S>& depth) {
    return (point.inverse_range / point.bearing.z() - depth.value) / depth.sigma;
  }
  static Errors errors_of(const Sensors& rig, const InAnchor& point, const Observation& seen,
                          const RelativeView<S>& view) {
    const Vec<S, 3> P = view.scaled_point(point.bearing, point.inverse_range);
    const Projection<S> projection = rig.vision.camera.project(P);
    Errors out;
    out.valid = projection.valid;
    if (!out.valid) return out;
    out.pixel = whitened(seen, Vec<S, 2>(projection.uv - cast_to<S>(seen.uv)));
    const InverseDepth<S>& depth = seen.depth.get();
    if (depth.valid) out.depth = (point.inverse_range / P.z() - depth.value) / depth.sigma;
    return out;
  }

  /// Adds the first R rows, by the pose of the frame and lambda.
  template <int R, class Rows>
  static void add_top(const RelativeView<S>& view, int slot, const Vec<S, 3>& P, S lambda,
                      const Mat<S, rows_per_view, 3>& J_P, const Vec<S, rows_per_view>& J_lambda,
                      const Vec<S, rows_per_view>& r, Rows& rows) {
    Mat<S, R, 3> J_top;
    Vec<S, R> J_lambda_top, r_top;
    for (int k = 0; k < R; ++k) {
      for (int c = 0; c < 3; ++c) J_top(k, c) = J_P(k, c);
      J_lambda_top[k] = J_lambda[k];
      r_top[k] = r[k];
    }
    rows.template add<R>(slot, view.template target_jacobian<R>(J_top, P, lambda), J_lambda_top, r_top);
  }
};

}  // namespace plumbline
