#pragma once
/// Levenberg-Marquardt on a pose graph in slices of bounded work.                          docs/math/pose_graph.md
///
///   solver.begin(graph);                        // a copy of the poses; measurements are read from the graph
///   while (!solver.iterate(budget)) {}          // one call a frame: the result does not depend on the budget
///   graph.set_poses(solver.nodes(), [&](int k) { return solver.pose(k); });
/// The gain-ratio rule is docs/math/solver.md (14)-(15); odometry counts as least squares, loops with a robust kernel.
/// A last pass without damping at the solution gives the marginal covariance of the newest node and the chi-square of
/// each loop. Until it is done, the graph must keep its nodes, loops and measurements; nodes may be added.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/map/pose_graph.hpp"
#include "plumbline/map/pose_graph_equations.hpp"
#include "plumbline/solver/gain_ratio_damping.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

/// A is the scalar of the normal equations and of the cost: double, also where poses and measurements are float.
template <class Graph, template <class> class Loss = Cauchy, class A = double>
class PoseGraphSolver {
 public:
  using Residual = typename Graph::Residual;
  using S = typename Graph::Scalar;
  using Pose = typename Graph::Pose;
  static constexpr int dim = Graph::dim;
  static_assert(RobustLoss<Loss<A>>);

  /// Cauchy as wide for `dim` rows as its default is for one: 2.385 sqrt(dim). Other kernels have their own default.
  static Loss<A> default_loss() {
    Loss<A> loss;
    if constexpr (std::is_same_v<Loss<A>, Cauchy<A>>) loss.c *= std::sqrt(A(dim));
    return loss;
  }

  /// Starts at the poses of the graph.
  void begin(const Graph& graph, const LevenbergMarquardtOptions& options = {}, const Loss<A>& loss = default_loss()) {
    graph_ = &graph;
    options_ = options;
    loss_ = loss;
    nodes_ = graph.nodes();
    loops_ = graph.loops();
    for (int k = 0; k < nodes_; ++k) pose_[std::size_t(k)] = graph.pose(k);
    summary_ = {};
    covariance_valid_ = nodes_ == 1;
    set_zero(covariance_);
    chi2_.fill(A(0));
    damping_ = {options.mu_initial};
    last_pass_ = false;
    phase_ = Phase::done;
    if (nodes_ < 2) {
      summary_.termination = LevenbergMarquardtEnd::converged;
      return;
    }
    const auto ends_of = [&graph](int l) { return std::array<int, 2>{graph.loop(l).i, graph.loop(l).j}; };
    equations_.set_structure(nodes_, loops_, ends_of);
    start_pass();
  }

  /// Works until about `budget` units are spent, one for each edge, node or block of the factor. True when it is done.
  /// A call exceeds its budget by less than the blocks of one row of the factor, (2 MaxLoops + 1)^2 / 2.
  bool iterate(int budget) {
    while (!done() && budget > 0) budget -= advance();
    return done();
  }
  bool done() const { return phase_ == Phase::done; }

  int nodes() const { return nodes_; }
  /// T_map_node, the best so far.
  const Pose& pose(int node) const { return pose_[std::size_t(node)]; }
  /// Cost, iterations and why it ended; complete when done.
  const LevenbergMarquardtSummary& summary() const { return summary_; }
  /// Covariance of the right increment of the newest node, the first one fixed; loops count with their robust weight.
  bool covariance_valid() const { return covariance_valid_; }
  const Mat<A, dim, dim>& newest_covariance() const { return covariance_; }
  /// Squared whitened residual of loop l at the solution, of `dim` degrees of freedom.
  A chi2(int loop) const { return chi2_[std::size_t(loop)]; }
  /// Its weight there: 1 for an inlier, near 0 for a rejected loop.
  A weight(int loop) const { return loss_.weight(chi2(loop)); }

 private:
  enum class Phase : std::uint8_t { loops, chain, rows, ends, steps, trial_loops, trial_chain, done };
  using End = LevenbergMarquardtEnd;

  /// One unit of work of the current phase; returns how many units it is.
  int advance() {
    switch (phase_) {
      case Phase::loops: return add_loop();
      case Phase::chain: return add_odometry();
      case Phase::rows: return factorize_row();
      case Phase::ends: return solve_end();
      case Phase::steps: return step();
      case Phase::trial_loops: return trial_loop();
      case Phase::trial_chain: return trial_odometry();
      case Phase::done: break;
    }
    return 1;
  }
  void start(Phase phase, int index) {
    phase_ = phase;
    index_ = index;
  }
  void start_pass() {
    equations_.reset(last_pass_ ? A(0) : A(damping_.mu));
    sum_ = A(0);
    start(loops_ > 0 ? Phase::loops : Phase::chain, loops_ > 0 ? 0 : 1);
  }

  int add_loop() {
    const typename Graph::Loop& loop = graph_->loop(index_);
    const auto rows = loop.edge.template linearize<A>(pose(loop.i), pose(loop.j));
    const A chi2 = squared_norm(rows.r);
    chi2_[std::size_t(index_)] = chi2;
    sum_ += loss_.rho(chi2);
    if (!std::isfinite(sum_)) return not_finite();
    equations_.add_loop(loop.i, loop.j, rows.J_i, rows.J_j, rows.r, loss_.weight(chi2));
    if (++index_ == loops_) start(Phase::chain, 1);
    return 1;
  }
  int add_odometry() {
    const auto rows = graph_->odometry(index_).template linearize<A>(pose(index_ - 1), pose(index_));
    sum_ += squared_norm(rows.r);
    if (!std::isfinite(sum_)) return not_finite();
    if (!equations_.add_odometry(index_, rows.J_i, rows.J_j, rows.r)) return singular();
    if (++index_ == nodes_) linearized();
    return 1;
  }
  void linearized() {
    cost_ = sum_ / 2;
    if (summary_.accepted == 0) summary_.initial_cost = double(cost_);
    start(Phase::rows, 0);
  }
  int factorize_row() {
    const int row = index_;
    if (!equations_.factorize_row(row)) return singular();
    if (++index_ == equations_.ends()) {
      if (last_pass_) {
        covariance_ = equations_.newest_covariance();
        covariance_valid_ = all_finite(covariance_);
        phase_ = Phase::done;
      } else {
        start(Phase::ends, equations_.ends() - 1);
      }
    }
    return 1 + row * (row + 1) / 2;
  }
  int solve_end() {
    const int units = 1 + (equations_.ends() - index_) / dim;
    equations_.solve_end(index_);
    if (--index_ < 0) start(Phase::steps, nodes_ - 1);
    return units;
  }
  int step() {
    const Vec<S, dim> d = cast_to<S>(equations_.step(index_));
    trial_[std::size_t(index_)] = Residual::moved(pose(index_), d);
    if (--index_ == 0) solved();
    return 1;
  }
  void solved() {
    ++summary_.iterations;
    trial_[0] = pose(0);
    predicted_ = double(equations_.predicted_decrease());
    if (!std::isfinite(predicted_)) return reject(false, double(cost_));
    if (predicted_ <= options_.step_tolerance * options_.step_tolerance / 2) return finish(End::converged);
    sum_ = A(0);
    start(loops_ > 0 ? Phase::trial_loops : Phase::trial_chain, loops_ > 0 ? 0 : 1);
  }
  int trial_loop() {
    const typename Graph::Loop& loop = graph_->loop(index_);
    sum_ += loss_.rho(loop.edge.template chi2<A>(trial_[std::size_t(loop.i)], trial_[std::size_t(loop.j)]));
    if (++index_ == loops_) start(Phase::trial_chain, 1);
    return 1;
  }
  int trial_odometry() {
    sum_ += graph_->odometry(index_).template chi2<A>(trial_[std::size_t(index_ - 1)], trial_[std::size_t(index_)]);
    if (++index_ == nodes_) evaluated(double(sum_ / 2));
    return 1;
  }
  void evaluated(double trial_cost) {
    const double cost = double(cost_), decrease = cost - trial_cost;
    if (!(decrease > 0)) return reject(true, trial_cost);  // also NaN
    std::copy_n(trial_.begin(), nodes_, pose_.begin());
    cost_ = A(trial_cost);
    ++summary_.accepted;
    damping_.accept(decrease, predicted_, options_.mu_min);
    next_iteration(decrease <= options_.relative_cost_tolerance * cost ? End::converged : End::max_iterations);
  }
  void reject(bool solved, double trial_cost) {
    damping_.reject();
    const bool rounding =
        solved && predicted_ <= options_.relative_cost_tolerance * double(cost_) && std::isfinite(trial_cost);
    next_iteration(rounding ? End::converged : damping_.mu <= options_.mu_max ? End::max_iterations : End::no_progress);
  }
  void next_iteration(End end) {
    if (end != End::max_iterations || summary_.iterations >= options_.max_iterations) return finish(end);
    start_pass();
  }
  int singular() {
    if (last_pass_) {
      phase_ = Phase::done;
    } else {
      ++summary_.iterations;
      reject(false, double(cost_));
    }
    return 1;
  }
  int not_finite() {
    cost_ = sum_;
    if (!last_pass_) finish(End::not_finite);
    phase_ = Phase::done;
    return 1;
  }
  /// The last pass follows, at the best poses.
  void finish(End end) {
    summary_.termination = end;
    summary_.mu = damping_.mu;
    summary_.final_cost = double(cost_);
    last_pass_ = true;
    start_pass();
  }

  const Graph* graph_ = nullptr;
  LevenbergMarquardtOptions options_;
  Loss<A> loss_;
  LevenbergMarquardtSummary summary_;
  Phase phase_ = Phase::done;
  bool last_pass_ = false, covariance_valid_ = false;
  int nodes_ = 0, loops_ = 0, index_ = 0;
  GainRatioDamping damping_;
  double predicted_ = 0;
  A sum_ = A(0), cost_ = A(0);  ///< sum of rho so far; cost of the best poses
  Mat<A, dim, dim> covariance_;
  std::array<A, std::size_t(Graph::max_loops)> chi2_;
  std::array<Pose, std::size_t(Graph::max_nodes)> pose_, trial_;
  PoseGraphEquations<A, dim, Graph::max_nodes, Graph::max_loops> equations_;
};

}  // namespace plumbline
