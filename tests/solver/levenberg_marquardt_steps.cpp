#include "plumbline/solver/levenberg_marquardt_steps.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// Rosenbrock's function, or one without a minimum nearby, as rows of two unknowns.
struct Valley {
  double x = -1.2, y = 1, trial_x = 0, trial_y = 0, wall = 0;
  double cost(double a, double b) const {
    return a > wall && wall != 0 ? std::numeric_limits<double>::quiet_NaN()
                                 : ((1 - a) * (1 - a) + 100 * (b - a * a) * (b - a * a)) / 2;
  }
  double linearize() const { return cost(x, y); }
  bool solve(double mu, double& predicted) {
    const double r1 = 1 - x, r2 = 10 * (y - x * x), j1 = -1, j2 = -20 * x, j3 = 10;
    double a = j1 * j1 + j2 * j2, b = j2 * j3, c = j3 * j3;
    const double g1 = j1 * r1 + j2 * r2, g2 = j3 * r2, da = mu * a, dc = mu * c;
    a += da;
    c += dc;
    const double determinant = a * c - b * b, dx = -(c * g1 - b * g2) / determinant,
                 dy = -(a * g2 - b * g1) / determinant;
    predicted = (da * dx * dx + dc * dy * dy - dx * g1 - dy * g2) / 2;
    trial_x = x + dx;
    trial_y = y + dy;
    return true;
  }
  double try_step() const { return cost(trial_x, trial_y); }
  void accept() {
    x = trial_x;
    y = trial_y;
  }
  void reject() {}
};

}  // namespace

TEST_CASE("levenberg_marquardt_steps: the decisions of levenberg_marquardt") {
  for (const double wall : {0.0, -0.5}) {
    for (const int max_iterations : {0, 3, 100}) {
      LevenbergMarquardtOptions options;
      options.max_iterations = max_iterations;
      Valley called, sliced;
      called.wall = sliced.wall = wall;
      const LevenbergMarquardtSummary expected = levenberg_marquardt(called, options);
      LevenbergMarquardtSteps steps;
      steps.begin(options, sliced.linearize());
      while (!steps.done()) {
        double predicted = 0;
        const bool ok = sliced.solve(steps.mu(), predicted);
        if (steps.solved(ok, predicted) && steps.evaluated(sliced.try_step())) sliced.accept();
      }
      CHECK(sliced.x == called.x);
      CHECK(sliced.y == called.y);
      CHECK(steps.summary().iterations == expected.iterations);
      CHECK(steps.summary().accepted == expected.accepted);
      CHECK(steps.summary().final_cost == expected.final_cost);
      CHECK(steps.summary().initial_cost == expected.initial_cost);
      CHECK(steps.summary().mu == expected.mu);
      CHECK(steps.summary().termination == expected.termination);
    }
  }
}

TEST_CASE("levenberg_marquardt_steps: singular systems and costs that are no numbers") {
  using End = LevenbergMarquardtEnd;
  LevenbergMarquardtSteps steps;
  CHECK(steps.done());
  steps.begin({}, std::numeric_limits<double>::quiet_NaN());
  CHECK(steps.summary().termination == End::not_finite);
  LevenbergMarquardtOptions options;
  options.max_iterations = 100;
  steps.begin(options, 1);
  int systems = 0;
  for (; !steps.done(); ++systems) CHECK(!steps.solved(false, 0));
  CHECK(systems == 9);  // mu from 1e-4 beyond 1e8
  CHECK(steps.summary().termination == End::no_progress);
  steps.begin(options, 1);
  CHECK(!steps.solved(true, std::numeric_limits<double>::infinity()));
  CHECK(!steps.done());
  CHECK(steps.solved(true, 0.5));
  CHECK(!steps.evaluated(std::numeric_limits<double>::quiet_NaN()));
  CHECK(!steps.done());
  CHECK(!steps.solved(true, 0));
  CHECK(steps.summary().termination == End::converged);
}
