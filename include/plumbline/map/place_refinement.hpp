#pragma once
/// Refinement of the pose of a camera in an older one, from features of which the older keyframe knows the ranges.
///                                                                                              docs/math/map.md 2
///   X_i = range_i b_i in the older camera o,  p_i = T_oc^-1 X_i,  n = p/|p|
///   r_i = n - b_c,   J_r = (I - n n^T)/|p| [ [p]x, -I ]        by the right increment of T_oc                    (1)
///   S_i = sigma_i^2 I + a_i a_i^T,  sigma_i^2 = sigma_c^2 + sigma_o^2 range_i^2 / |p_i|^2
///   a_i = (I - n n^T) R_oc^T b_i sigma_range / |p_i|           by the range, along the epipolar line             (2)
///   P = (sum J^T S_i^-1 J)^-1                                                                                    (3)
///   sigma_c of what was aligned is that of its patch, times the root of max(1, median(r^T S^-1 r) / 1.386)      (2a)

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

template <class S>
struct PlaceRow {
  const PlaceFeature* old;  ///< located, of the older keyframe
  Vec<S, 3> bearing;        ///< unit, in the current camera
  S sigma_rad;              ///< of `bearing`
  S sigma_old_rad;          ///< of the bearing in the older camera
  S sigma_patch_rad{};      ///< of a bearing that was aligned, by the patch alone
  bool is_aligned = false;  ///< `bearing` is that of the older keyframe's patch
  bool is_inlier = false;
};

template <class S, std::size_t N>
class PlaceRefinement {
 public:
  using Row = PlaceRow<S>;

  void clear() { rows_.clear(); }
  /// False where there is no room.
  bool add(const PlaceFeature& old, const Vec<S, 3>& bearing, S sigma_rad) {
    return rows_.push_back({&old, bearing, sigma_rad, S(old.sigma_rad), S(0)});
  }
  /// The patch of that feature was aligned: in place of its match. False where there is no room.
  bool add_aligned(const PlaceFeature& old, const Vec<S, 3>& bearing, S sigma_rad) {
    const Row aligned{&old, bearing, sigma_rad, S(0), sigma_rad, true};
    const auto match = std::find_if(rows_.begin(), rows_.end(), [&](const Row& row) { return row.old == &old; });
    if (match == rows_.end()) return rows_.push_back(aligned);
    *match = aligned;
    return true;
  }
  /// Removes what the last solution does not agree with.
  void keep_inliers() {
    std::size_t kept = 0;
    for (const Row& row : rows_) {
      if (row.is_inlier) rows_[kept++] = row;
    }
    while (rows_.size() > kept) rows_.pop_back();
  }
  std::size_t size() const { return rows_.size(); }
  const Row& operator[](std::size_t m) const { return rows_[m]; }

  int inliers() const { return inliers_; }
  /// Mean squared error of the inliers, of that which (2) tells.
  S noise2() const { return noise2_; }
  /// (3), of the right increment of the pose [rad, unit of the ranges].
  const Mat<S, 6, 6>& covariance() const { return covariance_; }

  /// Gauss-Newton on (1) with a Geman-McClure weight that closes to the gate of chi2. False when it has no solution.
  bool solve(SE3<S>& T_old_current, S chi2) {
    Mat<S, 6, 6> information;
    for (const S widening : {S(9), S(4), S(1), S(1), S(1)}) {
      DenseNormalEquations<S, 6> equations;
      set_zero(information);
      inliers_ = 0;
      S sum = S(0);
      const SE3<S> inverse = T_old_current.inverse();
      for (Row& row : rows_) {
        const Whitened at(row, inverse);
        row.is_inlier = at.e2 < chi2;
        if (!at.valid) continue;
        inliers_ += row.is_inlier;
        sum += row.is_inlier ? at.e2 : S(0);
        const S gate = widening * chi2, w = gate / (gate + at.e2), weight = w * w / at.variance;
        if (!(weight > S(0))) continue;
        const Mat<S, 3, 6> J = at.jacobian();
        equations.add(J, at.r, weight);
        for (int i = 0; i < 6; ++i)
          for (int j = 0; j < 6; ++j)
            for (int k = 0; k < 3; ++k) information(i, j) += weight * J(k, i) * J(k, j);
      }
      Vec<S, 6> d;
      if (!equations.solve(d) || !all_finite(d)) return false;
      T_old_current = plus(T_old_current, d);
      noise2_ = inliers_ > 0 ? sum / S(2 * inliers_) : S(1);
    }
    const Result<Mat<S, 6, 6>> L = square_root_information(information);  // L^T L = information^-1
    if (inliers_ < 6 || !L || !T_old_current.is_finite()) return false;
    covariance_ = L->transpose() * *L;
    return true;
  }
  /// (2a) at that pose.
  void scale_aligned(const SE3<S>& T_old_current) {
    const SE3<S> inverse = T_old_current.inverse();
    errors_.clear();
    for (Row& row : rows_) {
      if (!row.is_aligned) continue;
      row.sigma_rad = row.sigma_patch_rad;
      if (const Whitened at(row, inverse); at.valid) errors_.push_back(at.e2);
    }
    if (errors_.empty()) return;
    const auto middle = errors_.begin() + std::ptrdiff_t(errors_.size() / 2);
    std::nth_element(errors_.begin(), middle, errors_.end());
    constexpr S median_of_two = S(1.386294361);  // of chi-square with two degrees of freedom
    if (!(*middle > median_of_two)) return;
    for (Row& row : rows_) {
      if (row.is_aligned) row.sigma_rad *= std::sqrt(*middle / median_of_two);
    }
  }

 private:
  /// (1), (2) of a row: error and Jacobian without what the uncertainty of the range explains.
  struct Whitened {
    Whitened(const Row& row, const SE3<S>& T_current_old) {
      const Vec<S, 3> ray = T_current_old.rotation() * cast_to<S>(row.old->bearing);
      p = S(row.old->range) * ray + T_current_old.p();
      range = norm(p);
      if (!(range > S(0))) return;
      n = p / range;
      const S of_old = row.sigma_old_rad * S(row.old->range) / range;
      variance = row.sigma_rad * row.sigma_rad + of_old * of_old;
      across = S(row.old->sigma_range) / range * (ray - dot(n, ray) * n);
      const S across2 = squared_norm(across);
      share = across2 > S(0) ? (S(1) - S(1) / std::sqrt(S(1) + across2 / variance)) / across2 : S(0);
      r = n - row.bearing;
      r = r - (share * dot(across, r)) * across;
      e2 = squared_norm(r) / variance;
      valid = std::isfinite(e2);
    }
    Mat<S, 3, 6> jacobian() const {
      Mat<S, 3, 3> D;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) D(i, j) = (S(i == j) - n[i] * n[j]) / range;
      Mat<S, 3, 6> J;
      set_block(J, 0, 0, product(D, hat(p)));
      set_block(J, 0, 3, Mat<S, 3, 3>(-D));
      for (int k = 0; k < 6; ++k) {
        const S along = share * (across[0] * J(0, k) + across[1] * J(1, k) + across[2] * J(2, k));
        for (int i = 0; i < 3; ++i) J(i, k) -= along * across[i];
      }
      return J;
    }

    bool valid = false;
    Vec<S, 3> p, n, across, r;
    S range, variance, share, e2 = std::numeric_limits<S>::infinity();
  };

  FixedVector<Row, N> rows_;
  FixedVector<S, N> errors_;
  int inliers_ = 0;
  S noise2_ = S(1);
  Mat<S, 6, 6> covariance_ = zeros<S, 6, 6>();
};

}  // namespace plumbline
