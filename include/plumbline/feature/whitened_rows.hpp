#pragma once
/// Rows of a residual, whitened, by what one frame is estimated of: its pose and, of a rolling shutter, the readout
/// time.

#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <bool rolls>
using FrameLayout = std::conditional_t<rolls, Layout<state::Pose, state::ReadoutTime>, VisualLayout>;

template <class S, int Rows, class L>
struct WhitenedRows {
  bool valid = false;
  Vec<S, Rows> r;
  Mat<S, Rows, L::dim> J;

  /// r <- W r, with Jacobians by the pose and, where there is one, the readout time.
  static WhitenedRows of(const Mat<S, Rows, Rows>& W, const Vec<S, Rows>& r, const Mat<S, Rows, 6>& J_pose,
                         const Vec<S, Rows>& J_readout) {
    WhitenedRows out;
    out.valid = true;
    for (int i = 0; i < Rows; ++i) {
      S sum = S(0);
      for (int k = 0; k < Rows; ++k) sum += W(i, k) * r[k];
      out.r[i] = sum;
      for (int c = 0; c < state::Pose::dim; ++c) {
        S by_pose = S(0);
        for (int k = 0; k < Rows; ++k) by_pose += W(i, k) * J_pose(k, c);
        out.J(i, c) = by_pose;
      }
      if constexpr (L::template has<state::ReadoutTime>) {
        S by_readout = S(0);
        for (int k = 0; k < Rows; ++k) by_readout += W(i, k) * J_readout[k];
        out.J(i, L::template offset<state::ReadoutTime>) = by_readout;
      }
    }
    return out;
  }
};

}  // namespace plumbline
