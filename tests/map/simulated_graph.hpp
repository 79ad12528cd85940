#pragma once
// A robot that drives laps, its odometry with noise, and loop closures between laps, for each kind of residual.

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "plumbline/map/pose_graph.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::test {

/// A pose of the residual's kind.
template <class Residual>
typename Residual::Pose make_pose(const SO3<double>& R, const Vec<double, 3>& p, double scale = 1) {
  using S = typename Residual::Scalar;
  if constexpr (std::is_same_v<typename Residual::Pose, SE3<S>>) {
    return SE3<double>(R, p).cast<S>();
  } else {
    return Sim3<double>(scale, R, p).cast<S>();
  }
}

/// Everything that a pose is made of.
template <class S>
std::vector<S> numbers(const SE3<S>& T) {
  const Vec<S, 4> q = T.rotation().quaternion().coeffs();
  return {q[0], q[1], q[2], q[3], T.p()[0], T.p()[1], T.p()[2]};
}
template <class S>
std::vector<S> numbers(const Sim3<S>& X) {
  std::vector<S> out = numbers(SE3<S>(X.rotation(), X.t()));
  out.push_back(X.scale());
  return out;
}

/// Sigmas of [dphi or dpsi, dp, dsig].
template <class Residual>
Vec<typename Residual::Scalar, Residual::dim> sigmas(double angle, double position, double scale) {
  using S = typename Residual::Scalar;
  constexpr int angles = Residual::dim == 4 ? 1 : 3;
  Vec<S, Residual::dim> out;
  for (int k = 0; k < Residual::dim; ++k) out[k] = S(k < angles ? angle : k < angles + 3 ? position : scale);
  return out;
}

struct LoopEnd {
  int i, j;
};

template <class ResidualT, int MaxNodes = 60, int MaxLoops = 8>
struct SimulatedGraph {
  using Residual = ResidualT;
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  using Graph = PoseGraph<Residual, MaxNodes, MaxLoops>;
  using Vector = Vec<S, Residual::dim>;
  using Covariance = Mat<S, Residual::dim, Residual::dim>;

  std::vector<Pose> truth;
  std::unique_ptr<Graph> graph = std::make_unique<Graph>();
  Vector sigma_odometry = sigmas<Residual>(0.004, 0.02, 0.004), sigma_loop = sigmas<Residual>(0.005, 0.03, 0.005);
  testing::Gaussian noise;

  /// `noise_factor` = 0: exact measurements.
  SimulatedGraph(std::uint64_t seed, int nodes, const std::vector<LoopEnd>& loops, double noise_factor = 1,
                 double lap = 24)
      : noise(seed) {
    for (int k = 0; k < nodes; ++k) {
      const double angle = 2 * std::numbers::pi * k / lap, radius = lap / 12;
      const SO3<double> R = SO3<double>::exp({0, 0, angle}) * SO3<double>::exp(0.15 * noise.template vector<3>());
      const Vec<double, 3> p(radius * std::cos(angle), radius * std::sin(angle), 0.2 * std::sin(0.3 * k));
      truth.push_back(make_pose<Residual>(R, p + 0.1 * noise.template vector<3>(), 1 + 0.2 * std::sin(0.1 * k)));
    }
    bool ok = graph->add_first(truth[0]) == PoseGraphInsertion::inserted;
    for (int k = 1; k < nodes; ++k) {
      ok = ok && graph->add_node(measure(k - 1, k, sigma_odometry, noise_factor), covariance(sigma_odometry)) ==
                     PoseGraphInsertion::inserted;
    }
    for (const LoopEnd& loop : loops) ok = ok && add_loop(loop.i, loop.j, noise_factor);
    if (!ok) throw "the graph refused what it should take";
  }
  bool add_loop(int i, int j, double noise_factor = 1) {
    return graph->add_loop(i, j, measure(i, j, sigma_loop, noise_factor), covariance(sigma_loop)) ==
           PoseGraphInsertion::inserted;
  }

  /// The relative pose with noise of its right increment.
  Pose measure(int i, int j, const Vector& sigma, double noise_factor) {
    Vector d;
    for (int n = 0; n < Residual::dim; ++n) d[n] = sigma[n] * S(noise_factor * noise());
    return truth[i].inverse() * Residual::moved(truth[j], d);
  }
  static Covariance covariance(const Vector& sigma) {
    Covariance out = Covariance::Zero();
    for (int k = 0; k < Residual::dim; ++k) out(k, k) = sigma[k] * sigma[k];
    return out;
  }
  /// Error of an estimate of node k, a right increment: truth = estimate [+] error.
  Vector error(int k, const Pose& estimate) const {
    return Residual{truth[0].inverse() * estimate}.residual(truth[0], truth[k]);
  }
};

}  // namespace plumbline::test
