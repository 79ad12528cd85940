#pragma once
/// Linear least squares in velocities V_0 .. V_K, each row with two successive ones, and N unknowns x common to all
/// rows.
///
/// Each row is rotated into a triangle over (V_k, V_{k+1}, x | rhs); V_k is eliminated when its rows are complete.
/// Memory and time are linear in K, and the condition number is not squared.                docs/math/initialization.md
///
///   Givens:  [c s; -s c] [R_cc; row_c] = [sqrt(R_cc^2 + row_c^2); 0]  for each column c                          (6)

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// At most MaxFrames velocities, N common unknowns. Rows are whitened by the caller. In double.
template <int MaxFrames, int N>
class VelocityChain {
 public:
  /// Removes all rows.
  void clear() {
    R_ = {};
    eliminated_.clear();
  }

  /// Adds the equation row x = rhs.
  void add_common_row(const Mat<double, 1, N>& row, double rhs) {
    Row full{};
    for (int n = 0; n < N; ++n) full[6 + n] = row[n];
    full[columns - 1] = rhs;
    rotate_in(full);
  }

  /// Adds the equations A_begin V_k + A_end V_{k+1} + B x = c of the next interval.
  void add_interval(const Mat<double, 6, 3>& A_begin, const Mat<double, 6, 3>& A_end, const Mat<double, 6, N>& B,
                    const Vec<double, 6>& c) {
    PLUMBLINE_ASSERT(!eliminated_.full());
    for (int i = 0; i < 6; ++i) {
      Row row;
      for (int n = 0; n < 3; ++n) {
        row[n] = A_begin(i, n);
        row[3 + n] = A_end(i, n);
      }
      for (int n = 0; n < N; ++n) row[6 + n] = B(i, n);
      row[columns - 1] = c[i];
      rotate_in(row);
    }
    eliminated_.push_back({R_[0], R_[1], R_[2]});
    for (int i = 0; i < 3; ++i) {  // V_{k+1} takes the place of V_k
      R_[i] = R_[3 + i];
      R_[3 + i] = {};
      for (int n = 0; n < 3; ++n) R_[i][n] = std::exchange(R_[i][3 + n], 0.0);
    }
  }

  /// Solves; false when an unknown is not determined: a pivot below the rounding error of the largest one.
  bool solve() {
    const int last = int(eliminated_.size());
    double smallest = std::numeric_limits<double>::infinity(), largest = 0;
    const auto compare = [&](double pivot) {
      smallest = std::min(smallest, std::abs(pivot));
      largest = std::max(largest, std::abs(pivot));
    };
    for (int n = 0; n < N; ++n) compare(R_[6 + n][6 + n]);
    for (int k = 0; k <= last; ++k) {
      for (int i = 0; i < 3; ++i) compare(rows_of(k)[i][i]);
    }
    constexpr double min_pivot_ratio = 1e-13;  // numerics: singular below
    if (!(smallest > min_pivot_ratio * largest)) return false;

    for (int n = 0; n < N; ++n) common_[n] = R_[6 + n][columns - 1];
    back_substitute(&R_[6], 6, common_);
    Mat<double, N, N> inverse;
    for (int n = 0; n < N; ++n) {
      Vec<double, N> column;
      for (int i = 0; i < N; ++i) column[i] = i == n;
      back_substitute(&R_[6], 6, column);
      set_block(inverse, 0, n, column);
    }
    covariance_ = product_transposed(inverse, inverse);

    for (int k = last; k >= 0; --k) {
      Vec<double, 3>& v = velocities_[std::size_t(k)];
      for (int i = 0; i < 3; ++i) {
        const Row& row = rows_of(k)[i];
        v[i] = row[columns - 1];
        for (int n = 0; n < N; ++n) v[i] -= row[6 + n] * common_[n];
        for (int n = 0; n < 3 && k < last; ++n) v[i] -= row[3 + n] * velocities_[std::size_t(k) + 1][n];
      }
      back_substitute(rows_of(k), 0, v);
      if (!all_finite(v)) return false;
    }
    return all_finite(common_);
  }

  const Vec<double, N>& common() const { return common_; }             ///< x
  const Mat<double, N, N>& covariance() const { return covariance_; }  ///< of x
  Vec<double, 3> velocity(int k) const { return velocities_[std::size_t(k)]; }
  /// Sum of squared residuals.
  double cost() const { return R_[columns - 1][columns - 1] * R_[columns - 1][columns - 1]; }

 private:
  static constexpr int columns = N + 7;  // V_k, V_{k+1}, x | rhs
  using Row = std::array<double, columns>;

  /// Rotates a row into the triangle, (6).
  void rotate_in(Row& row) {
    for (int c = 0; c < columns; ++c) {
      const double length = elementary::hypot(R_[c][c], row[c]);
      if (length == 0) continue;
      const double cosine = R_[c][c] / length, sine = row[c] / length;
      for (int k = 0; k < columns; ++k) {
        const double upper = R_[c][k], lower = row[k];
        R_[c][k] = cosine * upper + sine * lower;  // (6)
        row[k] = cosine * lower - sine * upper;
      }
      row[c] = 0;
    }
  }

  /// The three rows of V_k in the triangle.
  const Row* rows_of(int k) const {
    return k < int(eliminated_.size()) ? eliminated_[std::size_t(k)].data() : R_.data();
  }

  /// x <- T^-1 x, the triangle T in `rows` from column `first` on.
  template <int M>
  static void back_substitute(const Row* rows, int first, Vec<double, M>& x) {
    for (int i = M - 1; i >= 0; --i) {
      for (int k = i + 1; k < M; ++k) x[i] -= rows[i][first + k] * x[k];
      x[i] /= rows[i][first + i];
    }
  }

  std::array<Row, columns> R_{};
  FixedVector<std::array<Row, 3>, std::size_t(MaxFrames) - 1> eliminated_;
  std::array<Vec<double, 3>, std::size_t(MaxFrames)> velocities_;
  Vec<double, N> common_;
  Mat<double, N, N> covariance_;
};

}  // namespace plumbline
