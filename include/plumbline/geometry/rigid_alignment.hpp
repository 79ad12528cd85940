#pragma once
/// Least-squares rigid or similarity alignment of two point sets (Umeyama), of any size.    docs/math/geometry.md 3
///
///   minimize sum_i w_i |p_i - (s R q_i + t)|^2
///   M = sum w (p - p_mean)(q - q_mean)^T = U diag(sv) V^T,  D = diag(1, 1, det(U V^T))                        (8)
///   R = U D V^T,  s = tr(diag(sv) D) / sum w |q - q_mean|^2 or 1,  t = p_mean - s R q_mean                    (9)
/// Means and M are updated point by point (West), so nothing is stored and nothing cancels far from the origin.

#include <concepts>

#include <Eigen/LU>
#include <Eigen/SVD>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/sim3.hpp"

namespace plumbline {

template <std::floating_point S>
class RigidAlignment {
 public:
  struct Result {
    bool valid = false;  ///< false for fewer than three points, collinear points and NaN
    Sim3<S> S_p_q;       ///< p = S_p_q * q
  };

  /// A pair of corresponding points [m]; weight > 0, ~ 1/variance.
  void add(const Vec<S, 3>& p, const Vec<S, 3>& q, S weight = S(1)) {
    weight_ += weight;
    const S gain = weight / weight_;
    const Vec<S, 3> dp = p - p_mean_, dq = q - q_mean_;
    p_mean_ += gain * dp;
    q_mean_ += gain * dq;
    moment_ += (weight - weight * gain) * dp * dq.transpose();
    q_variance_ += (weight - weight * gain) * squared_norm(dq);
    ++count_;
  }

  int count() const { return count_; }

  /// Collinear: the second singular value of M is below `collinear_ratio` of the first.
  Result solve(bool with_scale, S collinear_ratio = S(1e-3)) const {
    Result out;
    if (count_ < 3 || !all_finite(moment_)) return out;
    const Eigen::JacobiSVD<Mat<S, 3, 3>> svd(moment_, Eigen::ComputeFullU | Eigen::ComputeFullV);  // (8)
    const Vec<S, 3>& sv = svd.singularValues();
    if (!(sv[1] > collinear_ratio * sv[0])) return out;
    const Mat<S, 3, 3> V = svd.matrixV();
    Mat<S, 3, 3> U = svd.matrixU();
    const S sign = (U * V.transpose()).determinant() < 0 ? S(-1) : S(1);
    U.col(2) *= sign;
    const SO3<S> R = SO3<S>::from_matrix(U * V.transpose());  // (9)
    const S scale = with_scale ? (sv[0] + sv[1] + sign * sv[2]) / q_variance_ : S(1);
    out.S_p_q = Sim3<S>(scale, R, p_mean_ - scale * (R * q_mean_));
    out.valid = scale > 0 && out.S_p_q.is_finite();
    return out;
  }

 private:
  int count_ = 0;
  S weight_ = 0, q_variance_ = 0;
  Vec<S, 3> p_mean_ = zeros<S, 3>(), q_mean_ = zeros<S, 3>();
  Mat<S, 3, 3> moment_ = zeros<S, 3, 3>();
};

}  // namespace plumbline
