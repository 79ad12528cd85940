#pragma once
/// Prior of the first frame of a window: whitened rows that fix what no measurement determines. That is its whole pose,
/// the origin of the world; with gravity known only position and heading.                     docs/math/window.md

#include "plumbline/backend/window_options.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

/// Rows on the pose, at zero error.
template <class Layout>
Mat<double, state::Pose::dim, Layout::dim> pose_gauge(const WindowOptions& options) {
  Mat<double, state::Pose::dim, Layout::dim> J;
  set_zero(J);
  for (int k = 0; k < state::Pose::dim; ++k) {
    J(k, k) = 1 / (k < 3 ? options.sigma_first_rotation : options.sigma_first_position);
  }
  return J;
}

/// Rows on position and heading of a frame with orientation R_world_body, followed by the rows J_rest on the other
/// blocks of its state.
template <class Layout, int Rows>
Mat<double, 4 + Rows, Layout::dim> heading_gauge(const WindowOptions& options, const auto& R_world_body,
                                                 const Mat<double, Rows, Layout::dim>& J_rest) {
  constexpr int position = 3, position_rows = 4;  // of the pose's increment
  Mat<double, position_rows + Rows, Layout::dim> J;
  set_zero(J);
  for (int k = 0; k < 3; ++k) {
    J(k, position + k) = 1 / options.sigma_first_position;
    J(3, k) = double(R_world_body(2, k)) / options.sigma_first_rotation;  // heading: the vertical part of R dphi
  }
  for (int k = 0; k < Rows; ++k) {
    for (int c = 0; c < Layout::dim; ++c) J(position_rows + k, c) = J_rest(k, c);
  }
  return J;
}

}  // namespace plumbline
