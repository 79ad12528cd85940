#pragma once
/// A bearing of a map point in a keyframe, and its range where it was measured.
///                                                                      docs/math/local_bundle_adjustment.md (2)-(4)
///   q = Q R^T (X - c),  Q b = e3:   r_b = (q_x, q_y)/q_z / sigma,   r_r = (1/q_z - 1/range)/sigma(1/range)    (2)
/// which are the residuals of a point with known coordinates (residual/world_point.hpp) in a pinhole camera of focal
/// length 1 that looks along the measured bearing b. Their rows as sums over them, by the point, with robust weights:
///   G = sum w J^T J,   g = sum w J^T r                                                                        (3)
/// All derivatives by the pose follow from them:  J_pose = J [ [a]x, -I ],  a = X - c                          (4)
/// Not valid beyond 84 degrees from the bearing.

#include <cmath>
#include <concepts>
#include <limits>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

/// Huber kernels of the residuals of a bundle adjustment.
template <std::floating_point S>
struct BundleLosses {
  Huber<S> two_rows;  ///< bearing, segment, collinear point
  Huber<S> range;
};

template <std::floating_point S>
class BearingObservation {
 public:
  static constexpr S tangent_max = S(10);  ///< of the angle from the bearing

  /// Squares of r_b and r_r.
  struct Errors {
    bool valid;
    S bearing, range;
  };
  /// (3), in the frame of the map. Zero where it is not valid.
  struct Products {
    Mat<double, 3, 3> G;
    Vec<double, 3> g;
  };

  BearingObservation() = default;
  /// `range` 0: not measured.
  BearingObservation(const Vec<S, 3>& bearing, S sigma_rad, S range, S sigma_range) : per_sigma_(S(1) / sigma_rad) {
    const Vec<S, 3> b = normalized(bearing), x = unit_orthogonal(b), y = b.cross(x);
    Q_ << x[0], x[1], x[2], y[0], y[1], y[2], b[0], b[1], b[2];
    if (range > S(0)) {
      inverse_range_ = S(1) / range;
      per_sigma_range_ = range * range / sigma_range;
    }
  }
  bool is_finite() const {
    return all_finite(Q_) && std::isfinite(per_sigma_ * per_sigma_) &&
           std::isfinite(per_sigma_range_ * per_sigma_range_);
  }
  bool has_range() const { return per_sigma_range_ > S(0); }

  /// `view`: of the keyframe's camera, without extrinsics.
  [[gnu::flatten]] Errors errors(const BodyView<S>& view, const Vec<S, 3>& p_map) const {
    const Rows rows = linearize(view, p_map);
    return {rows.valid, rows.bearing_error, rows.range_error};
  }
  /// Sum of rho. Beyond the domain it is that of its boundary, so that no step gains by leaving it.
  S cost(const Errors& errors, const BundleLosses<S>& losses) const {
    const S r_b = tangent_max * per_sigma_, r_r = inverse_range_ * per_sigma_range_;
    const S bearing = errors.valid ? errors.bearing : r_b * r_b, range = errors.valid ? errors.range : r_r * r_r;
    return losses.two_rows.rho(bearing) + (has_range() ? losses.range.rho(range) : S(0));
  }
  [[gnu::flatten]] Products products(const BodyView<S>& view, const Vec<S, 3>& p_map,
                                     const BundleLosses<S>& losses) const {
    const Rows rows = linearize(view, p_map);
    Products out{zeros<double, 3, 3>(), zeros<double, 3>()};
    if (!rows.valid) return out;
    const double scale = double(per_sigma_) * double(per_sigma_) * double(losses.two_rows.weight(rows.bearing_error));
    for (int k = 0; k < 2; ++k) {
      add({double(rows.bearing.J_r_point(k, 0)), double(rows.bearing.J_r_point(k, 1)),
           double(rows.bearing.J_r_point(k, 2))},
          double(rows.bearing.r[k]), scale, out);
    }
    if (has_range()) {
      const double weight = double(losses.range.weight(rows.range_error));
      add({double(rows.range.J_r_point(0, 0)), double(rows.range.J_r_point(0, 1)), double(rows.range.J_r_point(0, 2))},
          double(rows.range.r[0]), double(per_sigma_range_) * double(per_sigma_range_) * weight, out);
    }
    out.G(0, 1) = out.G(1, 0);
    out.G(0, 2) = out.G(2, 0);
    out.G(1, 2) = out.G(2, 1);
    return out;
  }

 private:
  using Camera = Pinhole<S>;
  struct Rows {
    bool valid;
    S bearing_error, range_error;
    typename PointReprojection<Camera>::Linearized bearing;
    typename PointInverseDepth<S>::Linearized range;
  };

  EIGEN_ALWAYS_INLINE Rows linearize(const BodyView<S>& camera, const Vec<S, 3>& p_map) const {
    BodyView<S> view = camera;
    view.R_cam_body = Q_;
    Rows out;
    out.bearing = PointReprojection<Camera>{zeros<S, 2>()}.linearize({S(1), S(1), S(0), S(0)}, view, p_map);
    out.valid = out.bearing.valid && squared_norm(out.bearing.r) < tangent_max * tangent_max;
    if (!out.valid) return out;
    out.bearing_error = squared_norm(out.bearing.r) * per_sigma_ * per_sigma_;
    out.range_error = S(0);
    if (has_range()) {
      out.range = PointInverseDepth<S>{inverse_range_}.linearize(view, p_map);
      out.range_error = out.range.r[0] * out.range.r[0] * per_sigma_range_ * per_sigma_range_;
    }
    out.valid = out.bearing_error + out.range_error <= std::numeric_limits<S>::max();  // false for NaN
    return out;
  }
  /// The lower triangle of G, and g.
  static void add(const Vec<double, 3>& j, double r, double weight, Products& out) {
    for (int c = 0; c < 3; ++c) {
      const double wj = weight * j[c];
      for (int k = c; k < 3; ++k) out.G(k, c) += j[k] * wj;
      out.g[c] += wj * r;
    }
  }

  Mat<S, 3, 3> Q_;  ///< camera to a frame whose z axis is the bearing
  S per_sigma_ = S(0), inverse_range_ = S(0), per_sigma_range_ = S(0);
};

}  // namespace plumbline
