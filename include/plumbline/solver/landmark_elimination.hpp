#pragma once
/// All whitened, robust-weighted rows [J_p J_l | r] of ONE landmark of LandmarkDim columns, eliminated by thin QR.
///                                                                                   docs/math/solver.md (10)-(12)
///   J_l = Q1 R1,   A = Q1^T J_p,   c = Q1^T r                                                                (10)
///   H += J_p^T J_p - A^T A,   b += J_p^T r - A^T c          the reduced system of the poses                  (11)
///   dl = -R1^-1 (c + A d)                                   back-substitution                                (12)
/// Q1 comes from reflections of J_l, never from (J_l^T J_l)^-1: an ill-conditioned landmark does not square its
/// condition number. Levenberg-Marquardt appends the rows sqrt(mu) D to J_l, D^2 = clip(diag J_l^T J_l) as in (7).
///
/// The landmark is held by one block, its anchor, and a row is of the kind of RelativeEquations: it sees how another
/// block stands to the anchor. Without an anchor a row sees one block alone. J_p^T J_p, J_p^T r are sums over all
/// landmarks of a pair of blocks and do not depend on mu; A is linear in the rows, and A^T A of rank LandmarkDim.
/// Rows are kept as S, the arithmetic is that of Acc. Blocks of the normal equations may be larger than BlockDim: the
/// rows then belong to their leading parameters.
///
/// Per iteration: reset, add ..., add_to the pairs, then for each mu: eliminate, subtract_from, (solve),
/// back_substitute.

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstdint>
#include <limits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/householder.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/solver/relative_equations.hpp"

namespace plumbline {

template <class S, int LandmarkDim, int BlockDim, int MaxBlocks, int MaxRows, class Acc = double>
class LandmarkElimination {
 public:
  using Scalar = S;
  using Pairs = RelativeEquations<Acc, BlockDim, MaxBlocks>;
  static constexpr int landmark_dim = LandmarkDim, block_dim = BlockDim, max_rows = MaxRows;
  static constexpr int no_anchor = -1;

  LandmarkElimination() { reset(); }

  void reset(int anchor = no_anchor) {
    PLUMBLINE_ASSERT(anchor >= no_anchor && anchor < MaxBlocks);
    anchor_ = anchor;
    rows_ = 0;
    groups_.clear();
  }

  int rows() const { return rows_; }

  /// Rows that see `block` from the anchor, already multiplied with sqrt(weight); J by the parameters of `block`.
  /// False, and nothing kept, when full.
  template <int R>
  bool add(int block, const Mat<S, R, BlockDim>& J, const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    PLUMBLINE_ASSERT(block >= 0 && block < MaxBlocks && block != anchor_);
    if (rows_ + R > MaxRows) return false;
    J_p_.template middleRows<R>(rows_) = J;
    for (int k = 0; k < R; k += max_group_rows) {
      groups_.push_back({std::int16_t(block), std::int16_t(rows_ + k), std::int16_t(std::min(R - k, max_group_rows))});
    }
    return add(J_l, r);
  }
  /// Rows that touch no block (a depth measured in the anchor).
  template <int R>
  bool add(const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    if (rows_ + R > MaxRows) return false;
    J_l_.template middleRows<R>(rows_) = J_l;
    r_.template segment<R>(rows_) = r;
    rows_ += R;
    return true;
  }

  /// The part J_p^T J_p, J_p^T r of (11).
  void add_to(Pairs& pairs) const {
    for (const Group& group : groups_) {
      unrolled(group, [&]<int R>() {
        pairs.template add<R>(anchor_ == no_anchor ? group.block : anchor_, group.block,
                              J_p_.template middleRows<R>(group.first_row), r_.template segment<R>(group.first_row));
      });
    }
  }

  /// (10), with the transports of the pairs. False when the landmark is not determined (and mu is 0), or anything is
  /// not finite: leave it out then.
  bool eliminate(S mu, const Pairs& pairs) {
    mu_ = Acc(mu);
    Columns Q;
    if (!factorize(Q)) return false;
    c_.setZero();
    for (int k = 0; k < rows_; ++k) c_ += Acc(r_[k]) * Q[k];

    touched_.reset();
    for (const Group& group : groups_) {
      unrolled(group, [&]<int R>() {
        const Eigen::Matrix<Acc, R, BlockDim, Eigen::RowMajor> rows =
            J_p_.template middleRows<R>(group.first_row).template cast<Acc>();
        Strip A_j = touched_[group.block] ? A(group.block) : Strip(Strip::Zero());
        for (int k = 0; k < R; ++k) A_j.noalias() += Q[group.first_row + k] * rows.row(k);
        A(group.block) = A_j;
        touched_[group.block] = true;
      });
    }
    if (anchor_ != no_anchor) {
      Strip A_a = Strip::Zero();
      for (int j = 0; j < MaxBlocks; ++j) {
        if (touched_[j]) A_a.noalias() -= A(j) * pairs.transport(anchor_, j);
      }
      A(anchor_) = A_a;
      touched_[anchor_] = true;
    }
    return is_finite();
  }

  /// The part -A^T A, -A^T c of (11), after a successful eliminate.
  template <int NormalDim>
  void subtract_from(NormalEquations<Acc, NormalDim, MaxBlocks>& normal) const {
    static_assert(BlockDim <= NormalDim,
                  "plumbline: a pose of the landmark does not fit a block of the normal equations");
    for (int i = 0; i < MaxBlocks; ++i) {
      if (!touched_[i]) continue;
      normal.add_gradient(i, -A(i).transpose() * c_);
      for (int j = 0; j <= i; ++j) {
        if (touched_[j]) normal.template subtract_product<LandmarkDim, BlockDim>(i, A(i), j, A(j));
      }
    }
  }

  /// (12), for the poses' step d; `stride` is the block_dim of the normal equations.
  template <class D>
  Vec<S, LandmarkDim> back_substitute(const Eigen::MatrixBase<D>& d, int stride = BlockDim) const {
    Vec<Acc, LandmarkDim> dl = -c_;
    for (int j = 0; j < MaxBlocks; ++j) {
      if (touched_[j]) dl.noalias() -= A(j) * d.template segment<BlockDim>(j * stride).template cast<Acc>();
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

  /// (J_l^T J_l)^-1: the landmark's covariance given the poses. False when it is not determined.
  bool covariance(Mat<S, LandmarkDim, LandmarkDim>& out) {
    mu_ = Acc(0);
    Columns Q;
    if (!factorize(Q)) return false;
    Mat<Acc, LandmarkDim, LandmarkDim> inverse;  // of R1, column by column
    for (int c = 0; c < LandmarkDim; ++c) {
      Vec<Acc, LandmarkDim> x = Vec<Acc, LandmarkDim>::Unit(c);
      for (int k = LandmarkDim - 1; k >= 0; --k) {
        x[k] /= R1_(k, k);
        x.head(k) -= x[k] * R1_.col(k).head(k);
      }
      inverse.col(c) = x;
    }
    out = (inverse * inverse.transpose()).template cast<S>();
    return out.allFinite();
  }

  /// For marginalization: writes [J_l | J_p | r] to the upper left of `work`, at least rows() x (LandmarkDim + dim + 1)
  /// with the right-hand side in its last column, and eliminates J_l without damping. Returns its rank k: rows
  /// [k, rows()), columns [LandmarkDim, ...) are [Q2^T J_p | Q2^T r], Q2 the full orthogonal complement of J_l.
  template <class D>
  int reduced_rows(Eigen::MatrixBase<D>& work, const Pairs& pairs, int stride = BlockDim) const {
    using T = typename D::Scalar;
    work.topRows(rows_).setZero();
    work.topRows(rows_).template leftCols<LandmarkDim>() = J_l_.topRows(rows_).template cast<T>();
    work.col(work.cols() - 1).head(rows_) = r_.head(rows_).template cast<T>();
    for (const Group& group : groups_) {
      for (int k = group.first_row; k < group.first_row + group.rows; ++k) {
        const Mat<T, 1, BlockDim> row = J_p_.row(k).template cast<T>();
        work.row(k).template segment<BlockDim>(LandmarkDim + group.block * stride) = row;
        if (anchor_ == no_anchor) continue;
        work.row(k).template segment<BlockDim>(LandmarkDim + anchor_ * stride) =
            -row * pairs.transport(anchor_, group.block).template cast<T>();
      }
    }
    return eliminate_leading_columns(work.topRows(rows_), LandmarkDim);
  }

 private:
  static constexpr int max_group_rows = 3;  // longer ones are split
  struct Group {
    std::int16_t block, first_row, rows;
  };
  using Columns = std::array<Vec<Acc, LandmarkDim>, MaxRows + LandmarkDim>;  // those of J_l, row by row
  /// Columns of A that belong to one block.
  using Strip = Eigen::Matrix<Acc, LandmarkDim, BlockDim, Eigen::RowMajor>;

  /// Calls visit<R>() for a group of R rows.
  template <class Visit>
  static void unrolled(const Group& group, Visit&& visit) {
    switch (group.rows) {
      case 1: return visit.template operator()<1>();
      case 2: return visit.template operator()<2>();
      default: return visit.template operator()<max_group_rows>();
    }
  }

  Strip& A(int block) { return A_[std::size_t(block)]; }
  const Strip& A(int block) const { return A_[std::size_t(block)]; }
  bool is_finite() const {
    Acc sum = c_.sum();
    for (int j = 0; j < MaxBlocks; ++j) {
      if (touched_[j]) sum += A(j).sum();
    }
    return std::abs(sum) <= std::numeric_limits<Acc>::max();
  }

  /// Q1 (the rows of the damping, if any, are last), R1_ and damping_.
  bool factorize(Columns& Q) {
    using Row = Vec<Acc, LandmarkDim>;
    Row squared_norm = Row::Zero();
    for (int k = 0; k < rows_; ++k) squared_norm += J_l_.row(k).transpose().template cast<Acc>().cwiseAbs2();
    damping_ = squared_norm.unaryExpr([](Acc x) { return damping_scale(x); });
    squared_norm += mu_ * damping_;
    if constexpr (LandmarkDim == 1) {
      R1_(0, 0) = std::sqrt(squared_norm[0]);
      const Acc inverse = Acc(1) / R1_(0, 0);
      for (int k = 0; k < rows_; ++k) Q[k][0] = inverse * Acc(J_l_(k, 0));
      return squared_norm[0] > Acc(0);
    }
    Columns W;  // J_l, then [R1; 0]
    for (int k = 0; k < rows_; ++k) W[k] = J_l_.row(k).transpose().template cast<Acc>();
    int n = rows_;
    if (mu_ > 0) {
      const Row sqrt_damping = (mu_ * damping_).cwiseSqrt();
      for (int l = 0; l < LandmarkDim; ++l) W[n++] = sqrt_damping[l] * Row::Unit(l);
    }
    if (n < LandmarkDim) return false;
    Columns V;  // the reflections; full rows, as what stands left of the pivot is zero in W and Q
    Row tau;
    for (int k = 0; k < LandmarkDim; ++k) {
      Acc tail_squared = Acc(0);
      for (int i = k + 1; i < n; ++i) tail_squared += W[i][k] * W[i][k];
      const Acc pivot = W[k][k], norm = std::sqrt(pivot * pivot + tail_squared), beta = pivot > 0 ? -norm : norm;
      if (!(norm > rank_tolerance<Acc> * std::sqrt(squared_norm[k]))) return false;
      tau[k] = (beta - pivot) / beta;
      const Acc scale = Acc(1) / (pivot - beta);
      for (int i = k + 1; i < n; ++i) V[i][k] = scale * W[i][k];
      reflect_rows(V, k, tau[k], n, W);
      R1_.row(k) = W[k].transpose();
    }
    for (int k = 0; k < n; ++k) Q[k] = k < LandmarkDim ? Row(Row::Unit(k)) : Row(Row::Zero());
    for (int k = LandmarkDim - 1; k >= 0; --k) reflect_rows(V, k, tau[k], n, Q);
    return true;
  }
  /// Rows [k, n) of M by the reflection I - tau v v^T, v = [1; column k of V below row k].
  static void reflect_rows(const Columns& V, int k, Acc tau, int n, Columns& M) {
    Vec<Acc, LandmarkDim> w = M[k];
    for (int i = k + 1; i < n; ++i) w += V[i][k] * M[i];
    w *= tau;
    M[k] -= w;
    for (int i = k + 1; i < n; ++i) M[i] -= V[i][k] * w;
  }

  int rows_ = 0, anchor_ = no_anchor;
  Acc mu_ = Acc(0);
  FixedVector<Group, MaxRows> groups_;
  std::bitset<MaxBlocks> touched_;  ///< blocks that A has columns of
  Eigen::Matrix<S, MaxRows, BlockDim, Eigen::RowMajor> J_p_;
  Mat<S, MaxRows, LandmarkDim> J_l_;
  Vec<S, MaxRows> r_;
  std::array<Strip, MaxBlocks> A_;
  Mat<Acc, LandmarkDim, LandmarkDim> R1_;
  Vec<Acc, LandmarkDim> c_, damping_;
};

}  // namespace plumbline
