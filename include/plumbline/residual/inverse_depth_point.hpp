#pragma once
/// Residuals of a point anchored in one camera: its reprojection, or its measured depth, in another one.
/// docs/math/point.md
///
///   reprojection   r = uv(P~) - uv_measured                          2x1 [px]                                (5)
///                  J_r_<block> = J_uv_p(P~) dP~/d<block>             2x6, 2x6, 2x1
///   inverse depth  r = lambda / P~_z - 1/z_measured                  1x1 [1/m]                               (6)
///                  J_r_<block> = -(lambda/P~_z^2) e3^T dP~/d<block>  1x6, 1x6
///                  J_r_lambda  = 1/P~_z - (lambda/P~_z^2) t_z        1x1
/// The sigma of (6) is constant for a disparity sensor, in which 1/z is linear.

#include <concepts>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

/// Value and Jacobians of a residual by the anchor pose, the target pose and the parameters of the landmark: the
/// inverse range lambda of a point, or the four parameters of a line.
template <class S, int Rows, int LandmarkDim = 1>
struct AnchoredLinearization {
  bool valid;
  Vec<S, Rows> r;
  Mat<S, Rows, 6> J_r_anchor;
  Mat<S, Rows, 6> J_r_target;
  Mat<S, Rows, LandmarkDim> J_r_lambda;
};

template <CameraModel Camera>
struct InverseDepthReprojection {
  using Scalar = typename Camera::Scalar;
  using S = Scalar;
  static constexpr int dim = 2;
  using Linearized = AnchoredLinearization<S, dim>;
  /// Value and Jacobian by P~. Rows that share P~ are chained to poses and lambda together, by RelativeView (3), (4).
  struct ByPoint {
    bool valid;
    Vec<S, dim> r;
    Mat<S, dim, 3> J_r_P;
  };

  Vec<S, 2> uv_measured;

  ByPoint linearize(const Camera& camera, const Vec<S, 3>& P) const {
    const Projection<S> projection = camera.project(P);
    ByPoint out;
    out.valid = projection.valid;
    if (!out.valid) return out;
    out.r = projection.uv - uv_measured;  // (5)
    out.J_r_P = projection.J_uv_p;
    return out;
  }
  Linearized linearize(const Camera& camera, const RelativeView<S>& view, const Vec<S, 3>& bearing, S lambda) const {
    const ScaledPoint<S> point = view.linearize(bearing, lambda);
    const ByPoint lin = linearize(camera, point.P);
    Linearized out;
    out.valid = lin.valid;
    if (!out.valid) return out;
    out.r = lin.r;
    out.J_r_anchor = product(lin.J_r_P, point.J_anchor);
    out.J_r_target = product(lin.J_r_P, point.J_target);
    out.J_r_lambda = product(lin.J_r_P, view.t_target_anchor());
    return out;
  }
};

template <std::floating_point S>
struct InverseDepthMeasurement {
  using Scalar = S;
  static constexpr int dim = 1;
  static constexpr S z_min = S(1e-3);  ///< smallest P~_z, relative to the range from the anchor
  using Linearized = AnchoredLinearization<S, dim>;
  /// Value and Jacobians by P~, see InverseDepthReprojection, and by lambda.
  struct ByPoint {
    bool valid;
    Vec<S, dim> r;
    Mat<S, dim, 3> J_r_P;
    Vec<S, dim> J_r_lambda;  ///< with P~ fixed
  };

  S inverse_depth_measured;  ///< 1/z [1/m]

  ByPoint linearize(const Vec<S, 3>& P, S lambda) const {
    ByPoint out;
    out.valid = P.z() > z_min;
    if (!out.valid) return out;
    const S iz = S(1) / P.z();
    out.r(0) = lambda * iz - inverse_depth_measured;  // (6)
    out.J_r_P << S(0), S(0), -lambda * iz * iz;
    out.J_r_lambda(0) = iz;
    return out;
  }
  Linearized linearize(const RelativeView<S>& view, const Vec<S, 3>& bearing, S lambda) const {
    const ScaledPoint<S> point = view.linearize(bearing, lambda);
    const ByPoint lin = linearize(point.P, lambda);
    Linearized out;
    out.valid = lin.valid;
    if (!out.valid) return out;
    out.r = lin.r;
    out.J_r_anchor = product(lin.J_r_P, point.J_anchor);
    out.J_r_target = product(lin.J_r_P, point.J_target);
    out.J_r_lambda(0) = lin.J_r_lambda(0) + lin.J_r_P(0, 2) * view.t_target_anchor().z();
    return out;
  }
};

static_assert(Residual<InverseDepthMeasurement<float>> && Residual<InverseDepthMeasurement<double>>);

}  // namespace plumbline
