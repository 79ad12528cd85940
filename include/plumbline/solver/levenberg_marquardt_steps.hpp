#pragma once
/// Decisions of Levenberg-Marquardt for a problem that is solved in slices.                docs/math/solver.md
/// (14)-(15)
///
///   begin(cost)               the cost of the start
///   solved(ok, predicted)     after each linear system of damping mu(); true: the cost of its trial is asked for
///   evaluated(cost)           of the trial; true: it becomes the state
/// They are those of solver/levenberg_marquardt.hpp, which calls its problem; here the caller goes on when it wants to.

#include <cmath>

#include "plumbline/solver/gain_ratio_damping.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline {

class LevenbergMarquardtSteps {
 public:
  void begin(const LevenbergMarquardtOptions& options, double cost) {
    options_ = options;
    summary_ = {};
    damping_ = {options.mu_initial};
    summary_.initial_cost = summary_.final_cost = cost;
    done_ = false;
    if (!std::isfinite(cost)) finish(End::not_finite);
    if (options.max_iterations <= 0) finish(End::max_iterations);
  }
  bool done() const { return done_; }
  double mu() const { return damping_.mu; }
  /// Complete when done; the cost is that of the state so far.
  const LevenbergMarquardtSummary& summary() const { return summary_; }

  /// `ok`: the system has a finite solution. False: no trial.
  bool solved(bool ok, double predicted_decrease) {
    ++summary_.iterations;
    predicted_ = predicted_decrease;
    if (!ok || !std::isfinite(predicted_)) {
      reject(End::max_iterations);
      return false;
    }
    if (predicted_ > options_.step_tolerance * options_.step_tolerance / 2) return true;
    finish(End::converged);
    return false;
  }
  bool evaluated(double trial_cost) {
    const double cost = summary_.final_cost, decrease = cost - trial_cost;
    if (!(decrease > 0)) {  // also NaN
      const bool rounding = predicted_ <= options_.relative_cost_tolerance * cost && std::isfinite(trial_cost);
      reject(rounding ? End::converged : End::max_iterations);
      return false;
    }
    ++summary_.accepted;
    summary_.final_cost = trial_cost;
    damping_.accept(decrease, predicted_, options_.mu_min);
    next(decrease <= options_.relative_cost_tolerance * cost ? End::converged : End::max_iterations);
    return true;
  }

 private:
  using End = LevenbergMarquardtEnd;

  void reject(End end) {
    damping_.reject();
    next(end == End::converged || damping_.mu <= options_.mu_max ? end : End::no_progress);
  }
  /// max_iterations: not ended for another reason.
  void next(End end) {
    if (end != End::max_iterations || summary_.iterations >= options_.max_iterations) finish(end);
  }
  void finish(End end) {
    done_ = true;
    summary_.termination = end;
    summary_.mu = damping_.mu;
  }

  LevenbergMarquardtOptions options_;
  LevenbergMarquardtSummary summary_;
  GainRatioDamping damping_;
  double predicted_ = 0;
  bool done_ = true;
};

}  // namespace plumbline
