#pragma once
/// Linear least squares over a chain of velocities V_0 .. V_K and a few numbers x common to all of it, solved by
/// orthogonal elimination from the front: memory and time are linear in K.            docs/math/initialization.md
///
///   [ carry              0        carry | carry ]         [ R_k  .    .  | .  ]  kept for V_k
///   [ A_k                A_{k+1}  B     | c     ]  = Q    [  0   carry        ]  over (V_{k+1}, x | rhs)          (6)
///     V_k                V_{k+1}  x       rhs

#include <Eigen/QR>
#include <algorithm>
#include <cstddef>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"

namespace plumbline {

/// At most MaxFrames velocities, N common numbers. Rows are whitened by the caller. In double: it is solved once.
template <int MaxFrames, int N>
class VelocityChain {
 public:
  using Common = Vec<double, N>;

  /// No rows, no intervals.
  void clear() {
    carry_.setZero();
    common_rows_ = 0;
    eliminated_.clear();
  }

  /// Rows about x alone come first, at most N + 4 of them: row x = rhs.
  void add_common_row(const Mat<double, 1, N>& row, double rhs) {
    PLUMBLINE_ASSERT(common_rows_ < N + 4 && eliminated_.empty());
    carry_.row(common_rows_++) << 0, 0, 0, row, rhs;
  }

  /// Six rows A_k V_k + A_{k+1} V_{k+1} + B x = c of the next interval. False when there is no room.
  bool add_interval(const Mat<double, 6, 3>& A_begin, const Mat<double, 6, 3>& A_end, const Mat<double, 6, N>& B,
                    const Vec<double, 6>& c) {
    Mat<double, N + 10, N + 7> stacked;
    stacked.template topRows<N + 4>() << carry_.template leftCols<3>(), Mat<double, N + 4, 3>::Zero(),
        carry_.template rightCols<N + 1>();
    stacked.template bottomRows<6>() << A_begin, A_end, B, c;
    const Eigen::HouseholderQR<Mat<double, N + 10, N + 7>> qr(stacked);  // (6)
    const Mat<double, N + 7, N + 7> R = qr.matrixQR().template topRows<N + 7>().template triangularView<Eigen::Upper>();
    carry_ = R.template bottomRightCorner<N + 4, N + 4>();
    return eliminated_.push_back(R.template topRows<3>());
  }

  /// The minimum. False when anything is not determined: a pivot is lost in the rounding of the largest one.
  bool solve() {
    double smallest = carry_.diagonal().template head<N + 3>().cwiseAbs().minCoeff();
    double largest = carry_.diagonal().template head<N + 3>().cwiseAbs().maxCoeff();
    for (const Mat<double, 3, N + 7>& row : eliminated_) {
      smallest = std::min(smallest, row.diagonal().cwiseAbs().minCoeff());
      largest = std::max(largest, row.diagonal().cwiseAbs().maxCoeff());
    }
    if (!(smallest > 1e-13 * largest)) return false;
    const Mat<double, N, N> R = carry_.template block<N, N>(3, 3);
    const Mat<double, N, N> R_inverse =
        R.template triangularView<Eigen::Upper>().solve(Mat<double, N, N>::Identity().eval());
    common_ = R_inverse * carry_.template block<N, 1>(3, N + 3);
    covariance_ = R_inverse * R_inverse.transpose();
    cost_ = carry_(N + 3, N + 3) * carry_(N + 3, N + 3);

    Mat<double, 3, 3> R_v = carry_.template topLeftCorner<3, 3>();
    Vec<double, 3> rhs = carry_.template block<3, 1>(0, N + 3) - carry_.template block<3, N>(0, 3) * common_;
    for (int k = int(eliminated_.size());; --k) {
      velocities_.col(k) = R_v.template triangularView<Eigen::Upper>().solve(rhs);
      if (k == 0) break;
      const Mat<double, 3, N + 7>& row = eliminated_[std::size_t(k) - 1];
      R_v = row.template leftCols<3>();
      rhs = row.template rightCols<1>() - row.template block<3, 3>(0, 3) * velocities_.col(k) -
            row.template block<3, N>(0, 6) * common_;
    }
    return common_.allFinite();
  }

  const Common& common() const { return common_; }
  const Mat<double, N, N>& covariance() const { return covariance_; }  ///< of x
  double cost() const { return cost_; }                                ///< sum of squared residuals
  Vec<double, 3> velocity(int k) const { return velocities_.col(k); }

 private:
  Mat<double, N + 4, N + 4> carry_ = Mat<double, N + 4, N + 4>::Zero();  // over (V_k, x | rhs)
  int common_rows_ = 0;
  FixedVector<Mat<double, 3, N + 7>, std::size_t(MaxFrames) - 1> eliminated_;
  Mat<double, 3, MaxFrames> velocities_;  // a column each
  Common common_;
  Mat<double, N, N> covariance_;
  double cost_ = 0;
};

}  // namespace plumbline
