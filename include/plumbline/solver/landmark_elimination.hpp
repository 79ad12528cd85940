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
    keep<R>(slot(i), J_i.data(), slot(j), J_j.data(), J_l, r);
    return true;
  }
  /// Rows that touch one pose.
  template <int R>
  bool add(int i, const Mat<S, R, BlockDim>& J_i, const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    if (rows_ + R > MaxRows) return false;
    keep<R>(slot(i), J_i.data(), none, nullptr, J_l, r);
    return true;
  }
  /// Rows that touch no pose (e.g. a depth measured in the anchor).
  template <int R>
  bool add(const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    if (rows_ + R > MaxRows) return false;
    keep<R>(none, nullptr, none, nullptr, J_l, r);
    return true;
  }

  /// (10). False when the landmark is not determined (and mu is 0), or anything is not finite: leave it out then.
  bool eliminate(S mu) {
    mu_ = Acc(mu);
    Eigen::Matrix<Acc, MaxRows + LandmarkDim, LandmarkDim> Q;
    const int n = rows_ + (mu_ > 0 ? LandmarkDim : 0);
    Q.topRows(rows_) = J_l_.topRows(rows_).template cast<Acc>();
    for (int k = 0; k < LandmarkDim; ++k) damping_[k] = damping_scale(Q.col(k).head(rows_).squaredNorm());
    if (mu_ > 0) Q.middleRows(rows_, LandmarkDim) = (mu_ * damping_).cwiseSqrt().asDiagonal();
    if (!factorize(Q, n)) return false;

    c_.noalias() = Q.topRows(rows_).transpose() * r_.head(rows_).template cast<Acc>();
    A_.leftCols(int(touched_.size()) * BlockDim).setZero();
    for_each_group([&]<int R>(const Group& group) {
      const Mat<Acc, LandmarkDim, R> Qt = Q.template middleRows<R>(group.first_row).transpose();
      if (group.slot_i != none) A(group.slot_i).noalias() += Qt * J_p<R>(group, 0);
      if (group.slot_j != none) A(group.slot_j).noalias() += Qt * J_p<R>(group, 1);
    });
    return c_.allFinite() && A_.leftCols(int(touched_.size()) * BlockDim).allFinite();
  }

  /// (11), after a successful eliminate. The cost is not touched.
  template <class HS, int NormalDim, int NormalBlocks>
  void add_to(NormalEquations<HS, NormalDim, NormalBlocks>& normal) const {
    static_assert(BlockDim <= NormalDim,
                  "plumbline: a pose of the landmark does not fit a block of the normal equations");
    for_each_group([&]<int R>(const Group& group) {
      const Vec<Acc, R> r = r_.template segment<R>(group.first_row).template cast<Acc>();
      if (group.slot_i == none) return;
      const int i = touched_[group.slot_i];
      if (group.slot_j == none) return normal.add(i, J_p<R>(group, 0), r, HS(1));
      normal.add(i, J_p<R>(group, 0), int(touched_[group.slot_j]), J_p<R>(group, 1), r, HS(1));
    });
    const int slots = int(touched_.size());
    for (int s = 0; s < slots; ++s) {
      const Mat<Acc, LandmarkDim, BlockDim> A_s = A(s);
      normal.add(touched_[s], A_s, c_, HS(-1));
      for (int t = 0; t < slots; ++t) {
        if (touched_[t] < touched_[s]) {
          normal.add_product(touched_[s], A_s, touched_[t], Mat<Acc, LandmarkDim, BlockDim>(A(t)), HS(-1));
        }
      }
    }
  }

  /// (12), for the poses' step d; `stride` is the block_dim of the normal equations.
  template <class D>
  Vec<S, LandmarkDim> back_substitute(const Eigen::MatrixBase<D>& d, int stride = BlockDim) const {
    Vec<Acc, LandmarkDim> dl = -c_;
    for (int s = 0; s < int(touched_.size()); ++s) {
      dl -= A(s) * d.template segment<BlockDim>(touched_[s] * stride).template cast<Acc>();
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

  /// For marginalization: writes [J_l | J_p | r] to the upper left of `work`, at least rows() x (LandmarkDim + dim + 1)
  /// with the right-hand side in its last column, and eliminates J_l without damping. Returns its rank k: rows
  /// [k, rows()), columns [LandmarkDim, ...) are [Q2^T J_p | Q2^T r], Q2 the full orthogonal complement of J_l.
  template <class D>
  int reduced_rows(Eigen::MatrixBase<D>& work, int stride = BlockDim) const {
    work.topRows(rows_).setZero();
    work.topRows(rows_).template leftCols<LandmarkDim>() = J_l_.topRows(rows_).template cast<typename D::Scalar>();
    work.col(work.cols() - 1).head(rows_) = r_.head(rows_).template cast<typename D::Scalar>();
    for_each_group([&]<int R>(const Group& group) {
      for (int side = 0; side < 2; ++side) {
        const int slot = side == 0 ? group.slot_i : group.slot_j;
        if (slot == none) continue;
        work.template block<R, BlockDim>(group.first_row, LandmarkDim + touched_[slot] * stride) =
            J_p<R>(group, side).template cast<typename D::Scalar>();
      }
    });
    return eliminate_leading_columns(work.topRows(rows_), LandmarkDim);
  }

 private:
  static constexpr std::int16_t none = -1;
  static constexpr int max_group_rows = 4;  // longer ones are split: loops of constant length, few of them
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
  void keep(std::int16_t slot_i, const S* J_i, std::int16_t slot_j, const S* J_j, const Mat<S, R, LandmarkDim>& J_l,
            const Vec<S, R>& r) {
    J_l_.template middleRows<R>(rows_) = J_l;
    r_.template segment<R>(rows_) = r;
    keep_poses<R, R>(slot_i, J_i, slot_j, J_j);
  }
  /// The last R of AllRows rows.
  template <int R, int AllRows>
  void keep_poses(std::int16_t slot_i, const S* J_i, std::int16_t slot_j, const S* J_j) {
    constexpr int rows = R < max_group_rows ? R : max_group_rows;
    using All = Eigen::Map<const Mat<S, AllRows, BlockDim>>;
    using Kept = Eigen::Map<Mat<S, rows, BlockDim>>;
    S* const to = &J_p_[rows_ * 2 * BlockDim];
    if (J_i) Kept{to} = All(J_i).template middleRows<rows>(AllRows - R);
    if (J_j) Kept{to + rows* BlockDim} = All(J_j).template middleRows<rows>(AllRows - R);
    groups_.push_back({slot_i, slot_j, std::int16_t(rows_), std::int16_t(rows)});
    rows_ += rows;
    if constexpr (R > rows) keep_poses<R - rows, AllRows>(slot_i, J_i, slot_j, J_j);
  }

  template <class F>
  void for_each_group(F&& f) const {
    for (const Group& group : groups_) {
      switch (group.rows) {
        case 1: f.template operator()<1>(group); break;
        case 2: f.template operator()<2>(group); break;
        case 3: f.template operator()<3>(group); break;
        default: f.template operator()<max_group_rows>(group);
      }
    }
  }
  template <int R>
  Mat<Acc, R, BlockDim> J_p(const Group& group, int side) const {
    return Eigen::Map<const Mat<S, R, BlockDim>>(&J_p_[(group.first_row * 2 + side * R) * BlockDim])
        .template cast<Acc>();
  }
  auto A(int slot) { return A_.template middleCols<BlockDim>(slot * BlockDim); }
  auto A(int slot) const { return A_.template middleCols<BlockDim>(slot * BlockDim); }

  /// The first n rows of Q become Q1, and R1_ is set.
  bool factorize(Eigen::Matrix<Acc, MaxRows + LandmarkDim, LandmarkDim>& Q, int n) {
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
  std::array<S, std::size_t(MaxRows) * 2 * BlockDim> J_p_;  // per group: J_i, then J_j, each R x BlockDim
  Mat<S, MaxRows, LandmarkDim> J_l_;
  Vec<S, MaxRows> r_;
  Mat<Acc, LandmarkDim, BlockDim * MaxBlocks> A_;  // by slot
  Mat<Acc, LandmarkDim, LandmarkDim> R1_;
  Vec<Acc, LandmarkDim> c_, damping_;
};

}  // namespace plumbline
