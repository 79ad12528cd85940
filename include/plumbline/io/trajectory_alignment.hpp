#pragma once
/// Pairs the poses of two trajectories by time and aligns the one to the other.           docs/datasets.md,
/// "Evaluation"
///
///   p_reference ~ scale R p_estimate + t,  minimizing the sum of squared distances (Umeyama 1991)            (1)
/// With mu the means, C = sum (p_ref - mu_ref)(p_est - mu_est)^T / n = U D V^T:
///   R = U diag(1, 1, det U det V) V^T,  scale = tr(D diag(1, 1, det U det V)) / var(p_est)                   (2)
///   t = mu_ref - scale R mu_est
/// Yaw and position only (gravity is observed): R = Rz(atan2(C_10 - C_01, C_00 + C_11)).                      (3)

#include <cmath>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SVD>

#include "plumbline/io/association.hpp"
#include "plumbline/io/trajectory.hpp"

namespace plumbline::io {

struct PosePair {
  TimeNs t_ns;  ///< of the estimate
  SE3<double> reference, estimate;
};

/// Each pose of the estimate with the reference's nearest in time, at most `max_difference_s` away, each used once.
inline std::vector<PosePair> associate(const Trajectory& reference, const Trajectory& estimate,
                                       double max_difference_s) {
  std::vector<PosePair> pairs;
  for (const auto& [i, j] :
       associate_times(times_of(estimate), times_of(reference), std::llround(max_difference_s * 1e9)))
    pairs.push_back({estimate[i].t_ns, reference[j].T_world_body, estimate[i].T_world_body});
  return pairs;
}

enum class Alignment { none, se3, sim3, posyaw };

inline std::optional<Alignment> alignment_named(std::string_view name) {
  if (name == "none") return Alignment::none;
  if (name == "se3") return Alignment::se3;
  if (name == "sim3") return Alignment::sim3;
  if (name == "posyaw") return Alignment::posyaw;
  return std::nullopt;
}

/// x_reference = scale R x_estimate + t.
struct Similarity {
  double scale = 1;
  SE3<double> T;

  Vec<double, 3> operator*(const Vec<double, 3>& x) const { return T * Vec<double, 3>(scale * x); }
  SE3<double> operator*(const SE3<double>& pose) const { return {T.rotation() * pose.rotation(), *this * pose.p()}; }
};

/// The alignment (1) of the pairs' positions. Empty for fewer than three pairs, or none that move: nothing to align by.
inline std::optional<Similarity> align(const std::vector<PosePair>& pairs, Alignment alignment) {
  if (alignment == Alignment::none) return Similarity{};
  if (pairs.size() < 3) return std::nullopt;
  const double n = static_cast<double>(pairs.size());
  Vec<double, 3> mean_reference = Vec<double, 3>::Zero(), mean_estimate = Vec<double, 3>::Zero();
  for (const PosePair& pair : pairs) {
    mean_reference += pair.reference.p() / n;
    mean_estimate += pair.estimate.p() / n;
  }
  Mat<double, 3, 3> C = Mat<double, 3, 3>::Zero();
  double variance = 0;
  for (const PosePair& pair : pairs) {
    const Vec<double, 3> q = pair.estimate.p() - mean_estimate;
    C += (pair.reference.p() - mean_reference) * q.transpose() / n;
    variance += q.squaredNorm() / n;
  }
  if (!(variance > 0)) return std::nullopt;

  Similarity out;
  SO3<double> R;
  if (alignment == Alignment::posyaw) {
    R = SO3<double>::exp({0, 0, std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1))});  // (3)
  } else {
    const Eigen::JacobiSVD<Mat<double, 3, 3>> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
    const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
    const Vec<double, 3> signs(1, 1, sign);
    R = SO3<double>::from_matrix(svd.matrixU() * signs.asDiagonal() * svd.matrixV().transpose());  // (2)
    if (alignment == Alignment::sim3) out.scale = svd.singularValues().dot(signs) / variance;
  }
  if (!(out.scale > 0)) return std::nullopt;
  out.T = SE3<double>(R, mean_reference - R * Vec<double, 3>(out.scale * mean_estimate));
  return out;
}

}  // namespace plumbline::io
