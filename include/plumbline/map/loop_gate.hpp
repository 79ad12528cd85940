#pragma once
/// Chi-square test of a loop closure against the odometry between its two keyframes.       docs/math/pose_graph.md
///
///   T_ik = T_ij T_jk,   P_ik = A P_ij A^T + Q_jk,   A = transport(T_j, T_k)                                 (20)
///   r, J  of the loop's residual at the pose T_ij of the odometry, J by the increment of that pose
///   S = Q_loop + f J P_ij J^T,   chi^2 = r^T S^-1 r                                                         (21)
///   p = P(chi^2_n >= chi^2);   accepted if p >= rejected_share                                              (22)
/// A true loop is rejected in `rejected_share` of all cases, as long as f P is the covariance of the odometry. f is the
/// inflation of that covariance for unmodeled error. Not for the odometry that an earlier loop has corrected already:
/// its uncertainty is smaller than (20), so the test is then lenient.

#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/map/pose_graph.hpp"

namespace plumbline {

/// (23) Probability that a chi-square variable of `dof` degrees of freedom exceeds x >= 0. NaN for NaN.
inline double chi_square_survival(double x, int dof) {
  const double h = x / 2;
  double sum = 0;
  if (dof % 2 == 0) {  // exp(-h) sum h^i / i!
    double term = std::exp(-h);
    for (int i = 1; i <= dof / 2; term *= h / i++) sum += term;
    return sum;
  }
  double term = std::exp(-h) * std::sqrt(h) / 0.886226925452758014;  // exp(-h) h^(1/2) / Gamma(3/2)
  for (int i = 1; i <= dof / 2; term *= h / (0.5 + i++)) sum += term;
  return std::erfc(std::sqrt(h)) + sum;
}

/// (20): a pose and the covariance of its right increment, edge by edge.
template <RelativeResidual Residual>
class OdometryChain {
 public:
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  using Covariance = Mat<S, Residual::dim, Residual::dim>;

  /// Without uncertainty at `start`, whose z axis is vertical in the mode with heading and position.
  explicit OdometryChain(const Pose& start) : pose_(start), covariance_(zeros<Covariance>()) {}

  void append(const Pose& T_before_node, const Covariance& covariance) {
    const Pose next = pose_ * T_before_node;
    const Covariance A = Residual::transport(pose_, next);
    covariance_ = product_transposed(product(A, covariance_), A);
    for (int k = 0; k < int(covariance.size()); ++k) covariance_.data()[k] += covariance.data()[k];
    pose_ = next;
  }
  /// The pose of the last node, in the frame of the start's pose.
  const Pose& pose() const { return pose_; }
  const Covariance& covariance() const { return covariance_; }

 private:
  Pose pose_;
  Covariance covariance_;
};

struct LoopGateOptions {
  double rejected_share = 1e-3;     ///< of true loops, 0 to 1
  double covariance_inflation = 1;  ///< f of (21), for the covariance of the odometry
};

struct LoopGateResult {
  bool valid = false;     ///< false where a number is not finite, a node does not exist or S has no inverse
  bool accepted = false;  ///< (22)
  double chi2 = std::numeric_limits<double>::infinity();
  double p_value = 0;
};

/// Tests a measured pose T_i_j with its covariance, before it is inserted as a loop. Work: one (20) for each edge
/// between i and j, in either order.
template <class Residual, int MaxNodes, int MaxLoops>
LoopGateResult test_loop(const PoseGraph<Residual, MaxNodes, MaxLoops>& graph, int i, int j,
                         const typename Residual::Pose& T_i_j,
                         const Mat<typename Residual::Scalar, Residual::dim, Residual::dim>& covariance,
                         const LoopGateOptions& options = {}) {
  using S = typename Residual::Scalar;
  using Matrix = Mat<S, Residual::dim, Residual::dim>;
  LoopGateResult out;
  if (i < 0 || j < 0 || i >= graph.nodes() || j >= graph.nodes() || i == j) return out;
  if (!T_i_j.is_finite() || !all_finite(covariance)) return out;
  const int first = i < j ? i : j, last = i < j ? j : i;
  OdometryChain<Residual> chain(graph.pose(first));
  for (int k = first + 1; k <= last; ++k) {
    chain.append(graph.odometry(k).residual.measured, graph.odometry(k).covariance());
  }
  const typename Residual::Pose &T_i = i < j ? graph.pose(i) : chain.pose(),
                                &T_j = i < j ? chain.pose() : graph.pose(j);
  const typename Residual::Linearized lin = Residual{T_i_j}.linearize(T_i, T_j);
  if (!lin.valid) return out;
  const Matrix& J = i < j ? lin.J_r_j : lin.J_r_i;
  Matrix innovation = product_transposed(product(J, chain.covariance()), J);  // (21)
  for (int k = 0; k < int(innovation.size()); ++k) {
    innovation.data()[k] = covariance.data()[k] + S(options.covariance_inflation) * innovation.data()[k];
  }
  const Result<Matrix> L = square_root_information(innovation);
  if (!L) return out;
  out.chi2 = double(squared_norm(Vec<S, Residual::dim>(times(*L, lin.r))));
  out.p_value = chi_square_survival(out.chi2, Residual::dim);
  out.valid = std::isfinite(out.chi2);
  out.accepted = out.valid && out.p_value >= options.rejected_share;  // (22)
  return out;
}

}  // namespace plumbline
