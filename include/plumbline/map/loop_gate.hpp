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

/// What the odometry between nodes i and j predicts of a loop between them.
template <RelativeResidual ResidualT>
struct LoopPrediction {
  using Residual = ResidualT;
  using Pose = typename Residual::Pose;
  using Covariance = Mat<typename Residual::Scalar, Residual::dim, Residual::dim>;

  bool valid = false;  ///< false where a number is not finite, a node does not exist or S has no inverse
  Pose T_i, T_j;       ///< nodes that the odometry connects; that of the earlier node is in the graph
  Covariance L = zeros<Covariance>();  ///< L^T L = S^-1

  /// (21) of a measured pose near the one predicted for; infinite where it cannot be formed.
  double chi2(const Pose& T_i_j) const {
    const typename Residual::Linearized lin = Residual{T_i_j}.linearize(T_i, T_j);
    const double out = double(squared_norm(Vec<typename Residual::Scalar, Residual::dim>(times(L, lin.r))));
    return lin.valid && std::isfinite(out) ? out : std::numeric_limits<double>::infinity();
  }
};

/// (20) and S of (21) for a measured pose T_i_j with its covariance. Work: one (20) for each edge between i and j, in
/// either order.
template <class Residual, int MaxNodes, int MaxLoops>
LoopPrediction<Residual> predict_loop(const PoseGraph<Residual, MaxNodes, MaxLoops>& graph, int i, int j,
                                      const typename Residual::Pose& T_i_j,
                                      const typename LoopPrediction<Residual>::Covariance& covariance,
                                      const LoopGateOptions& options = {}) {
  using S = typename Residual::Scalar;
  using Matrix = typename LoopPrediction<Residual>::Covariance;
  LoopPrediction<Residual> out;
  if (i < 0 || j < 0 || i >= graph.nodes() || j >= graph.nodes() || i == j) return out;
  if (!T_i_j.is_finite() || !all_finite(covariance)) return out;
  const int first = i < j ? i : j, last = i < j ? j : i;
  OdometryChain<Residual> chain(graph.pose(first));
  for (int k = first + 1; k <= last; ++k) {
    chain.append(graph.odometry(k).residual.measured, graph.odometry(k).covariance());
  }
  out.T_i = i < j ? graph.pose(i) : chain.pose();
  out.T_j = i < j ? chain.pose() : graph.pose(j);
  const typename Residual::Linearized lin = Residual{T_i_j}.linearize(out.T_i, out.T_j);
  if (!lin.valid) return out;
  const Matrix& J = i < j ? lin.J_r_j : lin.J_r_i;
  Matrix innovation = product_transposed(product(J, chain.covariance()), J);  // (21)
  for (int k = 0; k < int(innovation.size()); ++k) {
    innovation.data()[k] = covariance.data()[k] + S(options.covariance_inflation) * innovation.data()[k];
  }
  const Result<Matrix> L = square_root_information(innovation);
  if (!L) return out;
  out.L = *L;
  out.valid = true;
  return out;
}

/// Tests a measured pose T_i_j against what was predicted for it, before it is inserted as a loop.
template <class Residual>
LoopGateResult test_loop(const LoopPrediction<Residual>& predicted, const typename Residual::Pose& T_i_j,
                         const LoopGateOptions& options = {}) {
  LoopGateResult out;
  if (!predicted.valid) return out;
  out.chi2 = predicted.chi2(T_i_j);
  out.p_value = chi_square_survival(out.chi2, Residual::dim);
  out.valid = std::isfinite(out.chi2);
  out.accepted = out.valid && out.p_value >= options.rejected_share;  // (22)
  return out;
}
template <class Residual, int MaxNodes, int MaxLoops>
LoopGateResult test_loop(const PoseGraph<Residual, MaxNodes, MaxLoops>& graph, int i, int j,
                         const typename Residual::Pose& T_i_j,
                         const typename LoopPrediction<Residual>::Covariance& covariance,
                         const LoopGateOptions& options = {}) {
  return test_loop(predict_loop(graph, i, j, T_i_j, covariance, options), T_i_j, options);
}

}  // namespace plumbline
