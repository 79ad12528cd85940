#pragma once
/// Residual of a line with fixed world coordinates, for pose refinement.                    docs/math/line.md
///
///   n_body = R^T (n_w - p x v_w), v_body = R^T v_w;  n_cam = R_cb (n_body - p_e x v_body), v_cam = R_cb v_body (16)
///   J_r_pose = (12);  J_r_line = [J_r_n A, (J_r_v - J_r_n [t]x) A],  A = R_cb R^T,  t = A p + R_cb p_e        (17)
/// J_r_line is by (n_w; v_w); with it the covariance of the line is added to that of the residual.

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "plumbline/residual/residual.hpp"
#include "plumbline/residual/world_point.hpp"

namespace plumbline {

/// The line in the camera of a view.                                                                            (16)
template <class S>
Plucker<S> line_in_camera(const BodyView<S>& view, const Plucker<S>& line_world) {
  const Vec<S, 3> v_body = view.R_body_world * line_world.v;
  const Vec<S, 3> n_body = view.R_body_world * (line_world.n - view.p_world_body.cross(line_world.v));
  return {view.R_cam_body * (n_body - view.p_body_cam.cross(v_body)), view.R_cam_body * v_body};
}

/// `Measurement`: LineReprojection or LineInverseDepth.
template <class Measurement>
struct WorldLine {
  using Scalar = typename Measurement::Scalar;
  using S = Scalar;
  static constexpr int dim = Measurement::dim;
  struct Linearized {
    bool valid;
    Vec<S, dim> r;
    Mat<S, dim, 6> J_r_pose;
    Mat<S, dim, 6> J_r_line;
  };

  Measurement measurement;

  Linearized linearize(const BodyView<S>& view, const Plucker<S>& line_world) const {
    const Plucker<S> in_cam = line_in_camera(view, line_world);
    const CameraLineLinearization<S, dim> lin = measurement.linearize(in_cam);
    Linearized out;
    out.valid = lin.valid;
    if (!out.valid) return out;
    const Mat<S, 3, 3> A = view.R_cam_body * view.R_body_world;
    const Vec<S, 3> t = A * view.p_world_body + view.R_cam_body * view.p_body_cam;
    Mat<S, dim, 3> by_direction = product(lin.J_r_n, hat(-t));
    by_direction += lin.J_r_v;
    out.r = lin.r;
    out.J_r_pose = line_pose_jacobian(lin, in_cam, view.R_cam_body, view.p_body_cam);
    set_block(out.J_r_line, 0, 0, product(lin.J_r_n, A));  // (17)
    set_block(out.J_r_line, 0, 3, product(by_direction, A));
    return out;
  }
};

static_assert(Residual<WorldLine<LineReprojection<float>>> && Residual<WorldLine<LineInverseDepth<double>>>);

}  // namespace plumbline
