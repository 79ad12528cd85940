#pragma once
/// Linear least squares over a chain of velocities V_0 .. V_K and a few numbers x common to all of it: each row is
/// rotated into a triangle over (V_k, V_{k+1}, x | rhs), and V_k leaves it when its rows are complete. Memory and time
/// are linear in K, no square of the condition number.                                docs/math/initialization.md
///
///   Givens:  [c s; -s c] [R_cc; row_c] = [sqrt(R_cc^2 + row_c^2); 0]  for each column c                          (6)

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// At most MaxFrames velocities, N common numbers. Rows are whitened by the caller. In double: it is solved once.
template <int MaxFrames, int N>
class VelocityChain {
 public:
  /// No rows, no intervals.
  void clear() {
    R_.setZero();
    eliminated_.clear();
  }

  /// row x = rhs
  void add_common_row(const Mat<double, 1, N>& row, double rhs) {
    Row full;
    full << Mat<double, 1, 6>::Zero(), row, rhs;
    rotate_in(full);
  }

  /// A_begin V_k + A_end V_{k+1} + B x = c of the next interval.
  void add_interval(const Mat<double, 6, 3>& A_begin, const Mat<double, 6, 3>& A_end, const Mat<double, 6, N>& B,
                    const Vec<double, 6>& c) {
    PLUMBLINE_ASSERT(!eliminated_.full());
    for (int i = 0; i < 6; ++i) {
      Row row;
      row << A_begin.row(i), A_end.row(i), B.row(i), c[i];
      rotate_in(row);
    }
    eliminated_.push_back(R_.template topRows<3>());
    const Mat<double, 3, columns> next = R_.template middleRows<3>(3);
    R_.template topRows<6>().setZero();
    R_.template block<3, 3>(0, 0) = next.template middleCols<3>(3);
    R_.template block<3, N + 1>(0, 6) = next.template rightCols<N + 1>();
  }

  /// The minimum. False when anything is not determined: a pivot is lost in the rounding of the largest one.
  bool solve() {
    Vec<double, N + 3> pivots;
    pivots << R_.diagonal().template head<3>(), R_.diagonal().template segment<N>(6);
    double smallest = pivots.cwiseAbs().minCoeff(), largest = pivots.cwiseAbs().maxCoeff();
    for (const Mat<double, 3, columns>& rows : eliminated_) {
      smallest = std::min(smallest, rows.diagonal().cwiseAbs().minCoeff());
      largest = std::max(largest, rows.diagonal().cwiseAbs().maxCoeff());
    }
    if (!(smallest > 1e-13 * largest)) return false;
    const Mat<double, N, N> R_x = R_.template block<N, N>(6, 6);
    common_ = back_substitute<N>(R_x, R_.template block<N, 1>(6, columns - 1));
    Mat<double, N, N> inverse;
    for (int i = 0; i < N; ++i) inverse.col(i) = back_substitute<N>(R_x, Vec<double, N>::Unit(i));
    covariance_ = inverse.lazyProduct(inverse.transpose());

    Mat<double, 3, columns> rows = R_.template topRows<3>();
    for (int k = int(eliminated_.size());; --k) {
      Vec<double, 3> rhs = rows.template rightCols<1>() - rows.template block<3, N>(0, 6).lazyProduct(common_);
      if (k < int(eliminated_.size())) rhs -= rows.template middleCols<3>(3) * velocities_.col(k + 1);
      velocities_.col(k) = back_substitute<3>(rows.template leftCols<3>(), rhs);
      if (k == 0) break;
      rows = eliminated_[std::size_t(k) - 1];
    }
    return common_.allFinite();
  }

  const Vec<double, N>& common() const { return common_; }             ///< x
  const Mat<double, N, N>& covariance() const { return covariance_; }  ///< of x
  Vec<double, 3> velocity(int k) const { return velocities_.col(k); }
  /// Sum of squared residuals.
  double cost() const { return R_(columns - 1, columns - 1) * R_(columns - 1, columns - 1); }

 private:
  static constexpr int columns = N + 7;  // V_k, V_{k+1}, x | rhs
  using Row = Mat<double, 1, columns>;
  using Triangle = Eigen::Matrix<double, columns, columns, Eigen::RowMajor>;

  void rotate_in(Row& row) {
    for (int c = 0; c < columns; ++c) {
      const double length = std::hypot(R_(c, c), row[c]);
      if (length == 0) continue;
      const double cosine = R_(c, c) / length, sine = row[c] / length;
      const Row upper = R_.row(c);
      R_.row(c) = cosine * upper + sine * row;  // (6)
      row = cosine * row - sine * upper;
      row[c] = 0;
    }
  }

  template <int M>
  static Vec<double, M> back_substitute(const Mat<double, M, M>& R, Vec<double, M> x) {
    for (int i = M - 1; i >= 0; --i) {
      x[i] /= R(i, i);
      x.head(i) -= x[i] * R.col(i).head(i);
    }
    return x;
  }

  Triangle R_ = Triangle::Zero();
  FixedVector<Mat<double, 3, columns>, std::size_t(MaxFrames) - 1> eliminated_;
  Mat<double, 3, MaxFrames> velocities_;  // a column each
  Vec<double, N> common_;
  Mat<double, N, N> covariance_;
};

}  // namespace plumbline
