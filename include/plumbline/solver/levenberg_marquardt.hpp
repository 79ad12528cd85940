#pragma once
/// Levenberg-Marquardt with Nielsen's gain-ratio rule, for any problem that can linearize, solve and try.
///                                                                                       docs/math/solver.md (14)-(15)
/// The damping is that of solver/gain_ratio_damping.hpp. A cost that is NaN or infinite is never accepted, and the
/// state is always that of the best cost seen.

#include <cmath>
#include <concepts>
#include <cstdint>

#include "plumbline/solver/gain_ratio_damping.hpp"

namespace plumbline {

/// A least-squares problem that holds its state, and a trial of it.
template <class P>
concept LeastSquaresProblem = requires(P problem, double mu, double& predicted_decrease) {
  { problem.linearize() } -> std::same_as<double>;                  // cost and normal equations at the state
  { problem.solve(mu, predicted_decrease) } -> std::same_as<bool>;  // the step of damping mu; false: singular
  { problem.try_step() } -> std::same_as<double>;                   // makes the trial; its cost
  problem.accept();                                                 // the trial becomes the state
  problem.reject();                                                 // the trial is dropped
};

struct LevenbergMarquardtOptions {
  int max_iterations = 10;                ///< linear systems solved, whether their step is accepted or not
  double relative_cost_tolerance = 1e-6;  ///< converged below this relative change of the cost
  double step_tolerance = 1e-8;           ///< converged below this length of the step in units of its own sigma
  double mu_initial = 1e-4;
  double mu_min = 1e-12;
  double mu_max = 1e8;  ///< beyond it no step will help
};

enum class LevenbergMarquardtEnd : std::uint8_t {
  converged,
  max_iterations,
  out_of_time,
  no_progress,  ///< no damping gives a step that lowers the cost
  not_finite,   ///< the cost of the state itself is not a number
};

struct LevenbergMarquardtSummary {
  int iterations = 0;  ///< linear systems solved
  int accepted = 0;
  double initial_cost = 0, final_cost = 0;  ///< 1/2 sum rho
  double mu = 0;                            ///< damping at the end, a good start for the next similar problem
  LevenbergMarquardtEnd termination = LevenbergMarquardtEnd::max_iterations;
};

/// `out_of_time()` is asked before each iteration.
template <LeastSquaresProblem Problem, std::predicate OutOfTime>
LevenbergMarquardtSummary levenberg_marquardt(Problem& problem, const LevenbergMarquardtOptions& options,
                                              OutOfTime&& out_of_time) {
  using End = LevenbergMarquardtEnd;
  LevenbergMarquardtSummary summary;
  double cost = problem.linearize();
  GainRatioDamping damping{options.mu_initial};
  summary.initial_cost = cost;
  bool linearized = true;
  const auto finish = [&](End end) {
    summary.final_cost = cost;
    summary.mu = damping.mu;
    summary.termination = end;
    return summary;
  };
  for (; summary.iterations < options.max_iterations; ++summary.iterations) {
    if (out_of_time()) return finish(End::out_of_time);
    if (!linearized) cost = problem.linearize();
    linearized = true;
    if (!std::isfinite(cost)) return finish(End::not_finite);

    double predicted = 0;
    const bool solved = problem.solve(damping.mu, predicted) && std::isfinite(predicted);
    if (solved && predicted <= options.step_tolerance * options.step_tolerance / 2) {
      ++summary.iterations;
      return finish(End::converged);
    }
    const double trial = solved ? problem.try_step() : cost, decrease = cost - trial;
    if (solved && decrease > 0) {  // false for NaN
      problem.accept();
      ++summary.accepted;
      linearized = false;
      damping.accept(decrease, predicted, options.mu_min);
      const bool converged = decrease <= options.relative_cost_tolerance * cost;
      cost = trial;
      if (converged) {
        ++summary.iterations;
        return finish(End::converged);
      }
      continue;
    }
    if (solved) problem.reject();
    damping.reject();
    if (solved && predicted <= options.relative_cost_tolerance * cost && std::isfinite(trial)) {
      ++summary.iterations;  // nothing left to gain but rounding
      return finish(End::converged);
    }
    if (!(damping.mu <= options.mu_max)) {
      ++summary.iterations;
      return finish(End::no_progress);
    }
  }
  return finish(End::max_iterations);
}

template <LeastSquaresProblem Problem>
LevenbergMarquardtSummary levenberg_marquardt(Problem& problem, const LevenbergMarquardtOptions& options = {}) {
  return levenberg_marquardt(problem, options, [] { return false; });
}

}  // namespace plumbline
