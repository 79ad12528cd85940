#pragma once
/// Elimination of ONE landmark of LandmarkDim columns from all its rows [J_p J_l | r], by thin QR.
///                                                                                   docs/math/solver.md (10)-(12)
///   J_l = Q1 R1,   A = Q1^T J_p,   c = Q1^T r                                                                (10)
///   H += J_p^T J_p - A^T A,   b += J_p^T r - A^T c          the reduced system of the poses                  (11)
///   dl = -R1^-1 (c + A d)                                   back-substitution                                (12)
/// Q1 comes from reflections of J_l, never from (J_l^T J_l)^-1: an ill-conditioned landmark does not square its
/// condition number. Levenberg-Marquardt appends the rows sqrt(mu) D to J_l, D^2 = clip(diag J_l^T J_l) as in (7).
///
/// Rows are those of landmark_rows.hpp, stored as S; the arithmetic is that of Acc. J_p^T J_p, J_p^T r are sums over
/// all landmarks of a pair of blocks and do not depend on mu; A is linear in the rows, and A^T A of rank LandmarkDim.
/// Blocks of the normal equations may be larger than BlockDim: the rows then belong to their leading parameters.
///
/// Per iteration: reset, add ..., add_to the pairs, then for each mu: eliminate, add_to the products of its anchor,
/// (complete, absorb), (solve), back_substitute_relative. One landmark alone may as well be complete at once, with the
/// anchor's columns of A: eliminate with the pairs, subtract_from, back_substitute.
///
/// Rows that depend on a second landmark, too, wait until it is eliminated. One more reflection with its triangle takes
/// it out of them: what is left belongs to the blocks and to the second landmark, which absorbs them in turn.
///   [ R1  A  0   | c ]        [ R1'  A'   B  | c'  ]
///   [ J_l J_p J_o | r ]   ->  [  0   J_p' J_o' | r' ]                                                        (13)

#include <array>
#include <bitset>
#include <cmath>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/anchored_products.hpp"
#include "plumbline/solver/block_rows.hpp"
#include "plumbline/solver/householder.hpp"
#include "plumbline/solver/landmark_qr.hpp"
#include "plumbline/solver/landmark_rows.hpp"
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

  void reset(int anchor = no_anchor) { rows_.reset(anchor); }

  int rows() const { return rows_.size(); }
  int anchor() const { return rows_.anchor(); }
  S residual(int k) const { return rows_.residual(k); }
  /// Another right-hand side of the same rows; `add_to` and `eliminate` are next.
  void set_residual(int k, S r) { rows_.set_residual(k, r); }
  /// c of (10), of the last elimination.
  const Vec<Acc, LandmarkDim>& eliminated() const { return c_; }

  /// As LandmarkRows::add.
  template <int R>
  bool add(int block, const Mat<S, R, BlockDim>& J, const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    return rows_.add(block, J, J_l, r);
  }
  template <int R>
  bool add(const Mat<S, R, LandmarkDim>& J_l, const Vec<S, R>& r) {
    return rows_.add(J_l, r);
  }

  /// The part J_p^T J_p, J_p^T r of (11).
  void add_to(Pairs& pairs) const { rows_.add_to(pairs); }

  /// (10), but for the anchor's columns of A. False when the landmark is not determined (and mu is 0), or anything is
  /// not finite: leave it out then.
  bool eliminate(S mu) {
    mu_ = Acc(mu);
    Columns Q;
    if (!qr_.factorize(rows_.J_l(), rows(), mu_, Q)) return false;
    set_zero(c_);
    for (int k = 0; k < rows(); ++k) {
      for (int l = 0; l < LandmarkDim; ++l) c_[l] += Acc(residual(k)) * Q[l][k];
    }
    touched_.reset();
    rows_.for_each_group([&]<int R>(const typename Rows::Group& group) {
      if (!touched_[group.block]) set_zero(A_[group.block]);
      touched_[group.block] = true;
      add_products<R>(Q, group.first_row, rows_.J_p(group), A_[group.block]);
    });
    return is_finite();
  }
  /// The anchor's columns too, with the transports of the pairs.
  void complete(const Pairs& pairs) {
    if (is_complete()) return;
    Strip A_a;
    set_zero(A_a);
    for (int j = 0; j < MaxBlocks; ++j) {
      if (!touched_[j]) continue;
      const typename Pairs::Block& M = pairs.transport(anchor(), j);
      for (int l = 0; l < LandmarkDim; ++l) A_a[l].noalias() -= M.transpose() * A_[j][l];
    }
    A_[anchor()] = A_a;
    touched_[anchor()] = true;
  }
  bool is_complete() const { return anchor() == no_anchor || touched_[anchor()]; }
  /// (10), complete.
  bool eliminate(S mu, const Pairs& pairs) {
    if (!eliminate(mu)) return false;
    complete(pairs);
    return true;
  }

  /// A^T A, A^T c of (11) without the anchor's columns, after a successful eliminate.
  void add_to(AnchoredProducts<Acc, BlockDim, MaxBlocks>& products) const { products.add(touched_, A_, c_); }
  /// The part -A^T A, -A^T c of (11), complete.
  template <int NormalDim, int NormalBlocks>
  void subtract_from(NormalEquations<Acc, NormalDim, NormalBlocks>& normal) const {
    static_assert(BlockDim <= NormalDim,
                  "plumbline: a pose of the landmark does not fit a block of the normal equations");
    for (int i = 0; i < MaxBlocks; ++i) {
      if (!touched_[i]) continue;
      Vec<Acc, BlockDim> g = -c_[0] * A_[i][0];
      for (int l = 1; l < LandmarkDim; ++l) g -= c_[l] * A_[i][l];
      normal.add_gradient(i, g);
      for (int j = 0; j <= i; ++j) {
        if (touched_[j]) normal.subtract_product(i, A_[i], j, A_[j]);
      }
    }
  }

  /// (13), complete, after its products were taken: J_l by this landmark of the rows `left`, which keep what remains.
  /// Returns B.
  template <std::size_t R, int OtherDim>
  Mat<Acc, LandmarkDim, OtherDim> absorb(std::array<Vec<Acc, LandmarkDim>, R> J_l,
                                         BlockRows<Acc, R, BlockDim, MaxBlocks, OtherDim>& left) {
    for (int j = 0; j < MaxBlocks; ++j) {
      if (touched_[j] && !left.touched[j]) set_zero(left.J[j]);
      if (left.touched[j] && !touched_[j]) set_zero(A_[j]);
    }
    touched_ |= left.touched;
    left.touched = touched_;
    std::array<Vec<Acc, OtherDim>, LandmarkDim> B;
    set_zero(B);
    for (int k = 0; k < LandmarkDim; ++k) {
      const Acc pivot = qr_.row(k)[k];
      Acc tail_squared = Acc(0);
      for (std::size_t i = 0; i < R; ++i) tail_squared += J_l[i][k] * J_l[i][k];
      if (!(tail_squared > Acc(0))) continue;
      const Acc norm = std::sqrt(pivot * pivot + tail_squared), beta = pivot > 0 ? -norm : norm;
      const Acc tau = (beta - pivot) / beta, scale = Acc(1) / (pivot - beta);
      std::array<Acc, R> v;
      for (std::size_t i = 0; i < R; ++i) v[i] = scale * J_l[i][k];
      reflect_few(tau, v, qr_.row(k), J_l);
      reflect_few(tau, v, c_[k], left.r);
      reflect_few(tau, v, B[k], left.J_other);
      for (int j = 0; j < MaxBlocks; ++j) {
        if (touched_[j]) reflect_few(tau, v, A_[j][k], left.J[j]);
      }
    }
    Mat<Acc, LandmarkDim, OtherDim> out;
    for (int k = 0; k < LandmarkDim; ++k) {
      for (int c = 0; c < OtherDim; ++c) out(k, c) = B[k][c];
    }
    return out;
  }

  /// (12), for the poses' step d; `stride` is the block_dim of the normal equations. `by_other`, of a landmark that
  /// absorbed rows: B of (13) times the step of the other one.
  template <class D>
  Vec<S, LandmarkDim> back_substitute(const Eigen::MatrixBase<D>& d, int stride = BlockDim,
                                      const Vec<Acc, LandmarkDim>& by_other = zeros<Acc, LandmarkDim>()) const {
    return step(by_other, [&](int j) {
      Vec<Acc, BlockDim> d_j;
      for (int c = 0; c < BlockDim; ++c) d_j[c] = Acc(d[j * stride + c]);
      return d_j;
    });
  }
  /// The same without the anchor's columns, from what RelativeEquations::steps gives of its anchor.
  Vec<S, LandmarkDim> back_substitute_relative(auto&& steps) const { return step(zeros<Acc, LandmarkDim>(), steps); }

  /// What this landmark adds to NormalEquations::predicted_decrease of the same mu, for its step dl.
  Acc predicted_decrease(const Vec<S, LandmarkDim>& dl) const {
    Acc sum = Acc(0);
    for (int l = 0; l < LandmarkDim; ++l) sum += c_[l] * c_[l] + mu_ * qr_.damping()[l] * Acc(dl[l]) * Acc(dl[l]);
    return sum / 2;
  }

  /// (J_l^T J_l)^-1: the landmark's covariance given the poses. False when it is not determined.
  bool covariance(Mat<S, LandmarkDim, LandmarkDim>& out) {
    if (rows() < LandmarkDim) return false;
    mu_ = Acc(0);
    Columns W;
    Column tau;
    if (qr_.triangularize(rows_.J_l(), rows(), mu_, W, tau) == 0) return false;
    std::array<Column, LandmarkDim> inverse;  // of R1, column by column
    for (int c = 0; c < LandmarkDim; ++c) {
      for (int l = 0; l < LandmarkDim; ++l) inverse[c][l] = Acc(l == c);
      qr_.solve(inverse[c]);
    }
    for (int r = 0; r < LandmarkDim; ++r) {
      for (int c = 0; c < LandmarkDim; ++c) {
        Acc sum = Acc(0);
        for (const Column& column : inverse) sum += column[r] * column[c];
        out(r, c) = S(sum);
      }
    }
    return all_finite(out);
  }

  /// For marginalization: LandmarkRows::reduced.
  template <class D>
  int reduced_rows(Eigen::MatrixBase<D>& work, const Pairs& pairs, int stride, auto&& write_more) const {
    return rows_.reduced(work, pairs, stride, write_more);
  }
  template <class D>
  int reduced_rows(Eigen::MatrixBase<D>& work, const Pairs& pairs, int stride = BlockDim) const {
    return reduced_rows(work, pairs, stride, [] {});
  }

 private:
  using Rows = LandmarkRows<S, LandmarkDim, BlockDim, MaxBlocks, MaxRows>;
  using Qr = LandmarkQr<S, LandmarkDim, MaxRows, Acc>;
  using Column = typename Qr::Column;
  using Columns = typename Qr::Columns;
  /// Columns of A that belong to one block, row by row.
  using Strip = std::array<Vec<Acc, BlockDim>, LandmarkDim>;

  bool is_finite() const {
    Acc sum = c_.sum();
    for (int j = 0; j < MaxBlocks; ++j) {
      for (int l = 0; touched_[j] && l < LandmarkDim; ++l) sum += A_[j][l].sum();
    }
    return std::isfinite(sum);
  }

  /// A += sum_k q_k j_k^T over R rows.
  template <int R>
  EIGEN_DONT_INLINE static void add_products(const Columns& Q, int first, const typename Rows::PoseRow* j, Strip& A) {
    std::array<Vec<Acc, BlockDim>, R> rows;
    for (int k = 0; k < R; ++k) {
      for (int c = 0; c < BlockDim; ++c) rows[k][c] = Acc(j[k][c]);
    }
    for (int l = 0; l < LandmarkDim; ++l) {
      Vec<Acc, BlockDim> sum = A[l];
      for (int k = 0; k < R; ++k) sum += Q[l][first + k] * rows[k];
      A[l] = sum;
    }
  }
  Vec<S, LandmarkDim> step(const Column& by_other, auto&& step_of) const {
    Column rhs = c_ + by_other;
    for (int j = 0; j < MaxBlocks; ++j) {
      if (!touched_[j]) continue;
      const Vec<Acc, BlockDim>& d_j = step_of(j);
      for (int l = 0; l < LandmarkDim; ++l) rhs[l] += plumbline::dot(A_[j][l], d_j);
    }
    qr_.solve(rhs);
    Vec<S, LandmarkDim> dl;
    for (int l = 0; l < LandmarkDim; ++l) dl[l] = S(-rhs[l]);
    return dl;
  }

  Rows rows_;
  Acc mu_ = Acc(0);
  std::bitset<MaxBlocks> touched_;  ///< blocks that A has columns of
  std::array<Strip, MaxBlocks> A_;
  Qr qr_;
  Column c_;
};

}  // namespace plumbline
