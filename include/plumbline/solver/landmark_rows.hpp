#pragma once
/// The whitened, robust-weighted rows [J_p J_l | r] of ONE landmark of LandmarkDim columns.    docs/math/solver.md (10)
///
/// The landmark is held by one block, its anchor, and a row is of the kind of RelativeEquations: it depends on the
/// relative pose of another block and the anchor. Without an anchor a row depends on one block alone. Rows of one call
/// stay together in groups of up to three, over which loops are unrolled.

#include <algorithm>
#include <array>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/householder.hpp"

namespace plumbline {

template <class S, int LandmarkDim, int BlockDim, int MaxBlocks, int MaxRows>
class LandmarkRows {
 public:
  static constexpr int no_anchor = -1;
  using PoseRow = std::array<S, BlockDim>;
  using LandmarkColumns = std::array<std::array<S, LandmarkDim>, MaxRows>;  ///< J_l, row by row
  struct Group {
    std::int16_t block, first_row, rows;
  };

  LandmarkRows() { reset(); }

  void reset(int anchor = no_anchor) {
    PLUMBLINE_ASSERT(anchor >= no_anchor && anchor < MaxBlocks);
    anchor_ = anchor;
    size_ = 0;
    groups_.clear();
  }

  int size() const { return size_; }
  int anchor() const { return anchor_; }
  S residual(int k) const { return r_[k]; }
  void set_residual(int k, S r) { r_[k] = r; }
  const LandmarkColumns& J_l() const { return J_l_; }
  const PoseRow* J_p(const Group& group) const { return &J_p_[group.first_row]; }

  /// Rows that see `block` from the anchor, already multiplied with sqrt(weight); J by the parameters of `block`.
  /// False, and nothing kept, when full.
  template <int R>
  bool add(int block, const Mat<S, R, BlockDim>& J, const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    PLUMBLINE_ASSERT(block >= 0 && block < MaxBlocks && block != anchor_);
    if (size_ + R > MaxRows) return false;
    for (int k = 0; k < R; ++k) {
      for (int c = 0; c < BlockDim; ++c) J_p_[size_ + k][c] = J(k, c);
    }
    constexpr int at_once = R % max_group_rows == 0 ? max_group_rows : 2;
    for (int k = 0; k < R; k += at_once) {
      groups_.push_back({std::int16_t(block), std::int16_t(size_ + k), std::int16_t(std::min(R - k, at_once))});
    }
    return add(J_l, r);
  }
  /// Rows that touch no block (a depth measured in the anchor).
  template <int R>
  bool add(const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    if (size_ + R > MaxRows) return false;
    for (int k = 0; k < R; ++k, ++size_) {
      for (int l = 0; l < LandmarkDim; ++l) J_l_[size_][l] = J_l(k, l);
      r_[size_] = r[k];
    }
    return true;
  }

  /// Calls visit<R>(group) for each group of R rows.
  template <class Visit>
  void for_each_group(Visit&& visit) const {
    for (const Group& group : groups_) {
      switch (group.rows) {
        case 1: visit.template operator()<1>(group); break;
        case 2: visit.template operator()<2>(group); break;
        default: visit.template operator()<max_group_rows>(group); break;
      }
    }
  }

  /// Adds J_p^T J_p, J_p^T r to the sums of all landmarks, RelativeEquations.
  template <class Pairs>
  void add_to(Pairs& pairs) const {
    for_each_group([&]<int R>(const Group& group) {
      pairs.template add<R>(anchor_ == no_anchor ? group.block : anchor_, group.block, J_p_[group.first_row].data(),
                            &r_[group.first_row]);
    });
  }

  /// For marginalization: writes [J_l | J_p | r] to the upper left of `work`, at least size() x (LandmarkDim + dim + 1)
  /// with the right-hand side in its last column, and eliminates J_l without damping. Returns its rank k: rows
  /// [k, size()), columns [LandmarkDim, ...) are [Q2^T J_p | Q2^T r], Q2 the full orthogonal complement of J_l.
  /// `write_more()` may write columns that no block has.
  template <class D, class Pairs>
  int reduced(Eigen::MatrixBase<D>& work, const Pairs& pairs, int stride, auto&& write_more) const {
    using T = typename D::Scalar;
    for (int k = 0; k < size_; ++k) {
      for (int c = LandmarkDim; c < int(work.cols()) - 1; ++c) work(k, c) = T(0);
      for (int l = 0; l < LandmarkDim; ++l) work(k, l) = T(J_l_[k][l]);
      work(k, work.cols() - 1) = T(r_[k]);
    }
    for (const Group& group : groups_) {
      for (int k = group.first_row; k < group.first_row + group.rows; ++k) {
        for (int c = 0; c < BlockDim; ++c) work(k, LandmarkDim + group.block * stride + c) = T(J_p_[k][c]);
        if (anchor_ == no_anchor) continue;
        const typename Pairs::Block& M = pairs.transport(anchor_, group.block);
        for (int c = 0; c < BlockDim; ++c) {
          T sum = T(0);
          for (int m = 0; m < BlockDim; ++m) sum -= T(J_p_[k][m]) * T(M(m, c));
          work(k, LandmarkDim + anchor_ * stride + c) = sum;
        }
      }
    }
    write_more();
    return eliminate_leading_columns(work.derived().data(), size_, int(work.cols()), int(work.derived().outerStride()),
                                     LandmarkDim);
  }

 private:
  static constexpr int max_group_rows = 3;  // longer ones are split

  int size_ = 0, anchor_ = no_anchor;
  FixedVector<Group, MaxRows> groups_;
  std::array<PoseRow, MaxRows> J_p_;
  LandmarkColumns J_l_;
  std::array<S, MaxRows> r_;
};

}  // namespace plumbline
