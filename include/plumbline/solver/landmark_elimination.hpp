#pragma once
/// All whitened, robust-weighted rows [J_p J_l | r] of ONE landmark of LandmarkDim columns, eliminated by thin QR.
///                                                                                   docs/math/solver.md (10)-(12)
///   J_l = Q1 R1,   A = Q1^T J_p,   c = Q1^T r                                                                (10)
///   H += J_p^T J_p - A^T A,   b += J_p^T r - A^T c          the reduced system of the poses                  (11)
///   dl = -R1^-1 (c + A d)                                   back-substitution                                (12)
/// Q1 comes from reflections of J_l, never from (J_l^T J_l)^-1: an ill-conditioned landmark does not square its
/// condition number. Levenberg-Marquardt appends the rows sqrt(mu) D to J_l, D^2 = clip(diag J_l^T J_l) as in (7).
///
/// Rows are kept as S, the arithmetic is that of Acc. A row touches at most two poses: work and memory are linear in
/// the rows, plus a rank-LandmarkDim update over the touched blocks. Blocks of the normal equations may be larger than
/// BlockDim: the rows then belong to their leading parameters.
///
/// Per iteration: reset, add ..., then for each mu: eliminate, add_to, (solve), back_substitute.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/householder.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <class S, int LandmarkDim, int BlockDim, int MaxBlocks, int MaxRows, class Acc = double>
class LandmarkElimination {
 public:
  using Scalar = S;
  static constexpr int landmark_dim = LandmarkDim, block_dim = BlockDim, max_rows = MaxRows;

  LandmarkElimination() { reset(); }

  void reset() {
    rows_ = 0;
    groups_.clear();
    touched_.clear();
    slot_of_block_.fill(none);
  }

  int rows() const { return rows_; }

  /// Rows that touch poses i and j, i != j, already multiplied with sqrt(weight). False, and nothing kept, when full.
  template <int R>
  bool add(int i, const Mat<S, R, BlockDim>& J_i, int j, const Mat<S, R, BlockDim>& J_j,
           const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    PLUMBLINE_ASSERT(i != j);
    if (rows_ + R > MaxRows) return false;
    for (int k = 0; k < R; ++k) {
      row(rows_ + k, 0) = J_i.row(k);
      row(rows_ + k, 1) = J_j.row(k);
    }
    keep<R>(slot(i), slot(j), J_l, r);
    return true;
  }
  /// Rows that touch one pose.
  template <int R>
  bool add(int i, const Mat<S, R, BlockDim>& J_i, const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    if (rows_ + R > MaxRows) return false;
    for (int k = 0; k < R; ++k) {
      row(rows_ + k, 0) = J_i.row(k);
      row(rows_ + k, 1).setZero();
    }
    keep<R>(slot(i), none, J_l, r);
    return true;
  }
  /// Rows that touch no pose (e.g. a depth measured in the anchor).
  template <int R>
  bool add(const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    if (rows_ + R > MaxRows) return false;
    keep<R>(none, none, J_l, r);
    return true;
  }

  /// (10). False when the landmark is not determined (and mu is 0), or anything is not finite: leave it out then.
  bool eliminate(S mu) {
    mu_ = Acc(mu);
    using Columns = Mat<Acc, MaxRows + LandmarkDim, LandmarkDim>;
    Columns Q = Columns::Zero();  // only n rows are used; compilers cannot see that and warn
    const int n = rows_ + (mu_ > 0 ? LandmarkDim : 0);
    Q.topRows(rows_) = J_l_.topRows(rows_).template cast<Acc>();
    for (int k = 0; k < LandmarkDim; ++k) damping_[k] = damping_scale(Q.col(k).head(rows_).squaredNorm());
    if (mu_ > 0) Q.middleRows(rows_, LandmarkDim) = (mu_ * damping_).cwiseSqrt().asDiagonal();
    if (!factorize(Q, n)) return false;

    const int columns = int(touched_.size()) * BlockDim;
    c_.noalias() = Q.topRows(rows_).transpose() * r_.head(rows_).template cast<Acc>();
    A_.leftCols(columns).setZero();
    for (const Group& group : groups_) {
      for (int k = group.first_row; k < group.first_row + group.rows; ++k) {
        for (int l = 0; l < LandmarkDim; ++l) {
          if (group.slot_i != none) A(l, group.slot_i) += Q(k, l) * row(k, 0).template cast<Acc>();
          if (group.slot_j != none) A(l, group.slot_j) += Q(k, l) * row(k, 1).template cast<Acc>();
        }
      }
    }
    return c_.allFinite() && A_.leftCols(columns).allFinite();
  }

  /// (11), after a successful eliminate. The cost is not touched.
  template <int NormalDim, int NormalBlocks>
  void add_to(NormalEquations<Acc, NormalDim, NormalBlocks>& normal) const {
    static_assert(BlockDim <= NormalDim,
                  "plumbline: a pose of the landmark does not fit a block of the normal equations");
    constexpr int B = BlockDim, stride = 2 * B;
    std::array<Acc, max_group_rows * stride> rows;
    std::array<Acc, max_group_rows> r;
    for (const Group& group : groups_) {
      if (group.slot_i == none) continue;
      for (int k = 0; k < group.rows; ++k) r[k] = Acc(r_[group.first_row + k]);
      for (int k = 0; k < group.rows * stride; ++k) rows[k] = Acc(J_p_[group.first_row * stride + k]);
      const int i = touched_[group.slot_i];
      normal.template add_product<B, B>(i, &rows[0], i, &rows[0], group.rows, stride, Acc(1));
      normal.template add_gradient<B>(i, &rows[0], &r[0], group.rows, stride, Acc(1));
      if (group.slot_j == none) continue;
      const int j = touched_[group.slot_j];
      normal.template add_product<B, B>(j, &rows[B], j, &rows[B], group.rows, stride, Acc(1));
      normal.template add_product<B, B>(std::max(i, j), &rows[i > j ? 0 : B], std::min(i, j), &rows[i > j ? B : 0],
                                        group.rows, stride, Acc(1));
      normal.template add_gradient<B>(j, &rows[B], &r[0], group.rows, stride, Acc(1));
    }
    for (int s = 0; s < int(touched_.size()); ++s) {
      const Acc* const A_s = A_.data() + s * B;
      normal.template add_gradient<B>(touched_[s], A_s, c_.data(), LandmarkDim, B * MaxBlocks, Acc(-1));
      for (int t = 0; t < int(touched_.size()); ++t) {
        if (touched_[t] > touched_[s]) continue;
        normal.template add_product<B, B>(touched_[s], A_s, touched_[t], A_.data() + t * B, LandmarkDim, B * MaxBlocks,
                                          Acc(-1));
      }
    }
  }

  /// (12), for the poses' step d; `stride` is the block_dim of the normal equations.
  template <class D>
  Vec<S, LandmarkDim> back_substitute(const Eigen::MatrixBase<D>& d, int stride = BlockDim) const {
    Vec<Acc, LandmarkDim> dl = -c_;
    for (int s = 0; s < int(touched_.size()); ++s) {
      const Vec<Acc, BlockDim> d_s = d.template segment<BlockDim>(touched_[s] * stride).template cast<Acc>();
      for (int l = 0; l < LandmarkDim; ++l) dl[l] -= A(l, s).dot(d_s.transpose());
    }
    for (int k = LandmarkDim - 1; k >= 0; --k) {
      dl[k] /= R1_(k, k);
      dl.head(k) -= dl[k] * R1_.col(k).head(k);
    }
    return dl.template cast<S>();
  }

  /// What this landmark adds to NormalEquations::predicted_decrease of the same mu, for its step dl.
  Acc predicted_decrease(const Vec<S, LandmarkDim>& dl) const {
    return (c_.squaredNorm() + mu_ * damping_.dot(dl.template cast<Acc>().cwiseAbs2())) / 2;
  }

  /// (R1^T R1)^-1, after a successful eliminate: the landmark's covariance given the poses (damping counts as rows).
  Mat<S, LandmarkDim, LandmarkDim> landmark_covariance() const {
    Mat<Acc, LandmarkDim, LandmarkDim> inverse;  // of R1, column by column
    for (int c = 0; c < LandmarkDim; ++c) {
      Vec<Acc, LandmarkDim> x = Vec<Acc, LandmarkDim>::Unit(c);
      for (int k = LandmarkDim - 1; k >= 0; --k) {
        x[k] /= R1_(k, k);
        x.head(k) -= x[k] * R1_.col(k).head(k);
      }
      inverse.col(c) = x;
    }
    return (inverse * inverse.transpose()).template cast<S>();
  }

  /// For marginalization: writes [J_l | J_p | r] to the upper left of `work`, at least rows() x (LandmarkDim + dim + 1)
  /// with the right-hand side in its last column, and eliminates J_l without damping. Returns its rank k: rows
  /// [k, rows()), columns [LandmarkDim, ...) are [Q2^T J_p | Q2^T r], Q2 the full orthogonal complement of J_l.
  template <class D>
  int reduced_rows(Eigen::MatrixBase<D>& work, int stride = BlockDim) const {
    work.topRows(rows_).setZero();
    work.topRows(rows_).template leftCols<LandmarkDim>() = J_l_.topRows(rows_).template cast<typename D::Scalar>();
    work.col(work.cols() - 1).head(rows_) = r_.head(rows_).template cast<typename D::Scalar>();
    for (const Group& group : groups_) {
      for (int side = 0; side < 2; ++side) {
        const int slot = side == 0 ? group.slot_i : group.slot_j;
        if (slot == none) continue;
        const int column = LandmarkDim + touched_[slot] * stride;
        for (int k = group.first_row; k < group.first_row + group.rows; ++k) {
          work.row(k).template segment<BlockDim>(column) = row(k, side).template cast<typename D::Scalar>();
        }
      }
    }
    return eliminate_leading_columns(work.topRows(rows_), LandmarkDim);
  }

 private:
  static constexpr std::int16_t none = -1;
  static constexpr int max_group_rows = 6;  // longer ones are split
  struct Group {
    std::int16_t slot_i, slot_j, first_row, rows;
  };

  std::int16_t slot(int block) {
    PLUMBLINE_ASSERT(block >= 0 && block < MaxBlocks);
    std::int16_t& slot = slot_of_block_[block];
    if (slot == none) {
      slot = std::int16_t(touched_.size());
      touched_.push_back(std::int16_t(block));
    }
    return slot;
  }

  template <int R>
  void keep(std::int16_t slot_i, std::int16_t slot_j, const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    J_l_.template middleRows<R>(rows_) = J_l;
    r_.template segment<R>(rows_) = r;
    for (int k = 0; k < R; k += max_group_rows) {
      groups_.push_back({slot_i, slot_j, std::int16_t(rows_ + k), std::int16_t(std::min(R - k, max_group_rows))});
    }
    rows_ += R;
  }

  /// Row k of J_i (side 0) or J_j (side 1).
  auto row(int k, int side) { return Eigen::Map<Mat<S, 1, BlockDim>>(&J_p_[(2 * k + side) * BlockDim]); }
  auto row(int k, int side) const { return Eigen::Map<const Mat<S, 1, BlockDim>>(&J_p_[(2 * k + side) * BlockDim]); }
  auto A(int l, int slot) { return Eigen::Map<Mat<Acc, 1, BlockDim>>(A_.data() + (l * MaxBlocks + slot) * BlockDim); }
  auto A(int l, int slot) const {
    return Eigen::Map<const Mat<Acc, 1, BlockDim>>(A_.data() + (l * MaxBlocks + slot) * BlockDim);
  }

  /// The first n rows of Q become Q1, and R1_ is set.
  bool factorize(Mat<Acc, MaxRows + LandmarkDim, LandmarkDim>& Q, int n) {
    if (n < LandmarkDim) return false;
    Vec<Acc, LandmarkDim> tau;
    R1_.setZero();
    for (int k = 0; k < LandmarkDim; ++k) {
      const Acc column_norm = Q.col(k).head(n).norm();
      const int tail = n - k - 1;
      tau[k] = make_reflection(Q(k, k), Q.col(k).segment(k + 1, tail));
      if (!(std::abs(Q(k, k)) > rank_tolerance<Acc> * column_norm)) return false;
      for (int c = k + 1; c < LandmarkDim; ++c) {
        reflect(tau[k], Q.col(k).segment(k + 1, tail), Q(k, c), Q.col(c).segment(k + 1, tail));
      }
      R1_.col(k).head(k + 1) = Q.col(k).head(k + 1);
    }
    for (int k = LandmarkDim - 1; k >= 0; --k) {  // Q1 = H_0 ... H_k applied to the first columns of the identity
      const int tail = n - k - 1;
      for (int c = k + 1; c < LandmarkDim; ++c) {
        Q(k, c) = Acc(0);
        reflect(tau[k], Q.col(k).segment(k + 1, tail), Q(k, c), Q.col(c).segment(k + 1, tail));
      }
      Q(k, k) = Acc(1) - tau[k];
      Q.col(k).segment(k + 1, tail) *= -tau[k];
    }
    return true;
  }

  int rows_ = 0;
  Acc mu_ = Acc(0);
  FixedVector<Group, MaxRows> groups_;
  FixedVector<std::int16_t, MaxBlocks> touched_;            // blocks, in the order of their first row
  std::array<std::int16_t, MaxBlocks> slot_of_block_;       // its inverse
  std::array<S, std::size_t(MaxRows) * 2 * BlockDim> J_p_;  // by rows: that of J_i, then that of J_j
  Mat<S, MaxRows, LandmarkDim> J_l_;
  Vec<S, MaxRows> r_;
  Eigen::Matrix<Acc, LandmarkDim, BlockDim * MaxBlocks, Eigen::RowMajor> A_;  // columns by slot
  Mat<Acc, LandmarkDim, LandmarkDim> R1_;
  Vec<Acc, LandmarkDim> c_, damping_;
};

}  // namespace plumbline
