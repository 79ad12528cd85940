#pragma once
/// Residuals of a point with fixed world coordinates, for pose refinement.                  docs/math/point.md
///
///   p_body = R^T (X - p),  p_cam = T_cam_body p_body
///   reprojection   r = uv(p_cam) - uv_measured                    2x1 [px]                                  (7)
///                  J_r_pose = J_uv_p R_cb [ [p_body]x , -I ]      2x6;  J_r_point = J_uv_p R_cb R^T   2x3
///   inverse depth  r = 1/p_cam_z - 1/z_measured                   1x1 [1/m]                                 (8)
///                  the rows above with -(1/p_cam_z^2) e3^T in place of J_uv_p

#include <concepts>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/residual.hpp"

namespace plumbline {

/// Pose of the observing body and its extrinsics, inverted once for all points.
template <class S>
struct BodyView {
  Mat<S, 3, 3> R_body_world, R_cam_body;
  Vec<S, 3> p_world_body, p_body_cam;

  BodyView() = default;
  BodyView(const SE3<S>& T_world_body, const SE3<S>& T_body_cam)
      : R_body_world(T_world_body.R().transpose()),
        R_cam_body(T_body_cam.R().transpose()),
        p_world_body(T_world_body.p()),
        p_body_cam(T_body_cam.p()) {}

  Vec<S, 3> body_point(const Vec<S, 3>& p_world) const { return R_body_world * (p_world - p_world_body); }
  Vec<S, 3> cam_point(const Vec<S, 3>& p_world) const { return R_cam_body * (body_point(p_world) - p_body_cam); }
};

template <class S, int Rows>
struct WorldPointLinearization {
  bool valid;
  Vec<S, Rows> r;
  Mat<S, Rows, 6> J_r_pose;
  Mat<S, Rows, 3> J_r_point;
};

/// Sets both Jacobians from that by the point in the body frame.
template <class S, int Rows>
void by_pose_and_point(const Mat<S, Rows, 3>& J_r_body, const BodyView<S>& view, const Vec<S, 3>& p_body,
                       WorldPointLinearization<S, Rows>& out) {
  set_block(out.J_r_pose, 0, 0, product(J_r_body, hat(p_body)));
  set_block(out.J_r_pose, 0, 3, Mat<S, Rows, 3>(-J_r_body));
  out.J_r_point = product(J_r_body, view.R_body_world);
}

template <CameraModel Camera>
struct PointReprojection {
  using Scalar = typename Camera::Scalar;
  using S = Scalar;
  static constexpr int dim = 2;
  using Linearized = WorldPointLinearization<S, dim>;

  Vec<S, 2> uv_measured;

  Linearized linearize(const Camera& camera, const BodyView<S>& view, const Vec<S, 3>& p_world) const {
    const Vec<S, 3> p_body = view.body_point(p_world);
    const Projection<S> projection = camera.project(Vec<S, 3>(view.R_cam_body * (p_body - view.p_body_cam)));
    Linearized out;
    out.valid = projection.valid;
    if (!out.valid) return out;
    out.r = projection.uv - uv_measured;  // (7)
    by_pose_and_point(product(projection.J_uv_p, view.R_cam_body), view, p_body, out);
    return out;
  }
};

template <std::floating_point S>
struct PointInverseDepth {
  using Scalar = S;
  static constexpr int dim = 1;
  static constexpr S z_min = S(1e-3);  ///< [m]
  using Linearized = WorldPointLinearization<S, dim>;

  S inverse_depth_measured;  ///< 1/z [1/m]

  Linearized linearize(const BodyView<S>& view, const Vec<S, 3>& p_world) const {
    const Vec<S, 3> p_body = view.body_point(p_world);
    const Mat<S, 1, 3> z_body = block<1, 3>(view.R_cam_body, 2, 0);
    const S z = product(z_body, Vec<S, 3>(p_body - view.p_body_cam))[0];
    Linearized out;
    out.valid = z > z_min;
    if (!out.valid) return out;
    out.r(0) = S(1) / z - inverse_depth_measured;  // (8)
    by_pose_and_point(Mat<S, 1, 3>((S(-1) / (z * z)) * z_body), view, p_body, out);
    return out;
  }
};

static_assert(Residual<PointInverseDepth<float>> && Residual<PointInverseDepth<double>>);

}  // namespace plumbline
