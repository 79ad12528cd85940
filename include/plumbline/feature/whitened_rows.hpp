#pragma once
/// Whitened rows of a residual by the pose of a frame.

#include "plumbline/core/matrix.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

template <class S, int Rows>
struct WhitenedRows {
  static constexpr int dim = state::Pose::dim;

  bool valid = false;
  Vec<S, Rows> r;
  Mat<S, Rows, dim> J;

  /// Rows W r, W J.
  static WhitenedRows of(const Mat<S, Rows, Rows>& W, const Vec<S, Rows>& r, const Mat<S, Rows, dim>& J) {
    WhitenedRows out;
    out.valid = true;
    for (int i = 0; i < Rows; ++i) {
      S sum = S(0);
      for (int k = 0; k < Rows; ++k) sum += W(i, k) * r[k];
      out.r[i] = sum;
      for (int c = 0; c < dim; ++c) {
        S by_pose = S(0);
        for (int k = 0; k < Rows; ++k) by_pose += W(i, k) * J(k, c);
        out.J(i, c) = by_pose;
      }
    }
    return out;
  }
};

}  // namespace plumbline
