#pragma once
/// Columns of the prior of a window: the corrections of all frames by slot, then those of extrinsics and time offset,
/// and last, with a rolling shutter, the readout time itself.                                   docs/math/window.md

#include "plumbline/core/matrix.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class Window, bool rolls = false>
struct PriorColumns {
  using Layout = typename Window::Layout;
  static constexpr int frame_dim = Layout::dim, extrinsics_dim = state::Extrinsics::dim;
  static constexpr int at_rig = Window::slots * frame_dim;  ///< first column of the rig
  static constexpr int at_extrinsics = at_rig, at_time_offset = at_rig + extrinsics_dim;
  static constexpr int at_readout = at_rig + RigLayout<Layout>::dim, dim = at_readout + (rolls ? 1 : 0);
  using Vector = Vec<double, dim>;
  using Adjoint = Mat<double, extrinsics_dim, extrinsics_dim>;

  /// The corrections at the present states, and the readout time in use [s].
  static Vector corrections(const Window& window, double readout_s) {
    Vector e;
    set_zero(e);
    if constexpr (rolls) e[at_readout] = readout_s;
    for (int k = 0; k < Window::slots; ++k) {
      if (!window[k].used) continue;
      const auto correction = window[k].state.correction();
      for (int c = 0; c < frame_dim; ++c) e[k * frame_dim + c] = double(correction[c]);
    }
    if constexpr (has_extrinsics<Layout>) {
      for (int c = 0; window.estimates_extrinsics() && c < extrinsics_dim; ++c)
        e[at_extrinsics + c] = double(window.extrinsics().correction()[c]);
      if (window.estimates_time_offset()) e[at_time_offset] = window.time_offset().correction()[0];
    }
    return e;
  }

  /// Adds to row k of `rows`, whose columns of the window begin at `first`, those of the extrinsics: the sum of the
  /// columns of all poses times E, the adjoint of T_body_cam, (6) of WindowEquations.
  static void move_with_extrinsics(auto& rows, int k, int first, const Adjoint& E) {
    Vec<double, extrinsics_dim> together = zeros<double, extrinsics_dim>();
    for (int slot = 0; slot < Window::slots; ++slot) {
      for (int c = 0; c < extrinsics_dim; ++c) together[c] += rows(k, first + slot * frame_dim + c);
    }
    for (int c = 0; c < extrinsics_dim; ++c) {
      for (int i = 0; i < extrinsics_dim; ++i) rows(k, first + at_extrinsics + c) += together[i] * E(i, c);
    }
  }
};

}  // namespace plumbline
