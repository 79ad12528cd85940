#include "plumbline/solver/levenberg_marquardt.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/solver/gauss_newton.hpp"

using namespace plumbline;

namespace {

/// Two parameters; Model gives r (2x1) and J (2x2).
template <class Model>
struct TwoParameters {
  Vec<double, 2> x, trial;
  Model model;
  DenseNormalEquations<double, 2> normal;
  int solved = 0;

  double cost(const Vec<double, 2>& at) const { return model.r(at).squaredNorm() / 2; }
  double linearize() {
    normal.reset();
    normal.add(model.J(x), model.r(x), 1.0);
    return cost(x);
  }
  bool solve(double mu, double& predicted_decrease) {
    ++solved;
    Vec<double, 2> d;
    if (!normal.solve(d, mu)) return false;
    trial = x + d;
    predicted_decrease = -d.dot(normal.b()) - d.dot(normal.H() * d) / 2;
    return true;
  }
  double try_step() { return cost(trial); }
  void accept() { x = trial; }
  void reject() {}
};

struct Rosenbrock {
  Vec<double, 2> r(const Vec<double, 2>& x) const { return {10 * (x[1] - x[0] * x[0]), 1 - x[0]}; }
  Mat<double, 2, 2> J(const Vec<double, 2>& x) const {
    return (Mat<double, 2, 2>() << -20 * x[0], 10, -1, 0).finished();
  }
};

/// Minimum at x = 1, not defined for x <= 0: full steps from far away leave the domain.
struct Logarithm {
  Vec<double, 2> r(const Vec<double, 2>& x) const { return {std::log(x[0]), x[1]}; }
  Mat<double, 2, 2> J(const Vec<double, 2>& x) const { return (Mat<double, 2, 2>() << 1 / x[0], 0, 0, 1).finished(); }
};

/// A gradient of the wrong sign.
struct WrongJacobian {
  Vec<double, 2> r(const Vec<double, 2>& x) const { return {1 + x.squaredNorm(), 0}; }
  Mat<double, 2, 2> J(const Vec<double, 2>&) const { return (Mat<double, 2, 2>() << 1, 1, 1, -1).finished(); }
};

static_assert(LeastSquaresProblem<TwoParameters<Rosenbrock>>);
static_assert(!LeastSquaresProblem<Rosenbrock>);

}  // namespace

TEST_CASE("levenberg_marquardt: Rosenbrock's valley") {
  TwoParameters<Rosenbrock> problem{{-1.2, 1}, {}, {}, {}};
  const auto summary = levenberg_marquardt(problem, {.max_iterations = 100, .relative_cost_tolerance = 1e-14});
  REQUIRE(summary.termination == LevenbergMarquardtEnd::converged);
  REQUIRE(summary.initial_cost == Approx(12.1));
  REQUIRE((problem.x - Vec<double, 2>(1, 1)).norm() < 1e-8);
  REQUIRE(summary.final_cost == problem.cost(problem.x));
  REQUIRE(summary.iterations == problem.solved);
  REQUIRE(summary.iterations < 40);
  REQUIRE(summary.accepted < summary.iterations);  // the valley bends: some steps are rejected
}

TEST_CASE("levenberg_marquardt: a trial that is not a number is rejected") {
  TwoParameters<Logarithm> problem{{20, 3}, {}, {}, {}};
  const auto summary = levenberg_marquardt(problem, {.max_iterations = 100, .relative_cost_tolerance = 1e-14});
  REQUIRE(summary.termination == LevenbergMarquardtEnd::converged);
  REQUIRE(problem.x[0] == Approx(1.0).epsilon(1e-7));
  REQUIRE(summary.iterations > summary.accepted);
}

TEST_CASE("levenberg_marquardt: ends at once where nothing can be done") {
  TwoParameters<Logarithm> undefined{{-1, 0}, {}, {}, {}};
  auto summary = levenberg_marquardt(undefined);
  REQUIRE(summary.termination == LevenbergMarquardtEnd::not_finite);
  REQUIRE(undefined.solved == 0);
  REQUIRE(undefined.x == Vec<double, 2>(-1, 0));

  TwoParameters<Rosenbrock> solved{{1, 1}, {}, {}, {}};
  summary = levenberg_marquardt(solved);
  REQUIRE(summary.termination == LevenbergMarquardtEnd::converged);
  REQUIRE(summary.iterations == 1);
  REQUIRE(summary.final_cost == 0.0);
}

TEST_CASE("levenberg_marquardt: the number of systems solved is bounded") {
  for (const int budget : {0, 1, 2, 7}) {
    TwoParameters<Rosenbrock> problem{{-1.2, 1}, {}, {}, {}};
    const auto summary = levenberg_marquardt(problem, {.max_iterations = budget});
    REQUIRE(problem.solved == budget);
    REQUIRE(summary.termination == LevenbergMarquardtEnd::max_iterations);
    REQUIRE(summary.final_cost == problem.cost(problem.x));
    REQUIRE(summary.final_cost <= summary.initial_cost);
  }
  TwoParameters<WrongJacobian> hopeless{{0, 0}, {}, {}, {}};
  const auto summary = levenberg_marquardt(hopeless, {.max_iterations = 1000});
  REQUIRE(hopeless.x == Vec<double, 2>(0, 0));
  REQUIRE(summary.accepted == 0);
  REQUIRE(summary.iterations < 30);
  REQUIRE(summary.termination != LevenbergMarquardtEnd::max_iterations);
}

TEST_CASE("levenberg_marquardt: stops when the time is over") {
  TwoParameters<Rosenbrock> problem{{-1.2, 1}, {}, {}, {}};
  int asked = 0;
  const auto summary = levenberg_marquardt(problem, {}, [&] { return ++asked > 3; });
  REQUIRE(summary.termination == LevenbergMarquardtEnd::out_of_time);
  REQUIRE(problem.solved == 3);
}
