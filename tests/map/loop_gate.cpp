#include "plumbline/map/loop_gate.hpp"

#include "catch.hpp"
#include "map/simulated_graph.hpp"

using namespace plumbline;
using test::SimulatedGraph;

TEST_CASE("loop_gate: chi-square quantiles") {
  // 95 % and 99.9 % of the tables
  for (const auto& [dof, x95, x999] : {std::tuple{1, 3.8415, 10.828},
                                       {2, 5.9915, 13.816},
                                       {3, 7.8147, 16.266},
                                       {4, 9.4877, 18.467},
                                       {6, 12.5916, 22.458},
                                       {7, 14.0671, 24.322}}) {
    REQUIRE(chi_square_survival(0, dof) == Approx(1));
    REQUIRE(chi_square_survival(x95, dof) == Approx(0.05).epsilon(1e-3));
    REQUIRE(chi_square_survival(x999, dof) == Approx(0.001).epsilon(1e-3));
    REQUIRE(chi_square_survival(1e4, dof) == 0);
    REQUIRE(std::isnan(chi_square_survival(NAN, dof)));
  }
}

TEMPLATE_TEST_CASE("loop_gate: the covariance of a chain is that of its last pose", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  constexpr int dim = TestType::dim, runs = 300, last = 25;
  double nees = 0;
  for (int run = 0; run < runs; ++run) {
    const SimulatedGraph<TestType> world(run, last + 1, {});
    OdometryChain<TestType> chain(world.truth[0]);
    for (int k = 1; k <= last; ++k) {
      chain.append(world.graph->odometry(k).residual.measured, world.graph->odometry(k).covariance());
    }
    const Vec<double, dim> e = world.error(last, chain.pose());
    nees += e.dot(Mat<double, dim, dim>(chain.covariance()).ldlt().solve(e)) / runs;
  }
  REQUIRE(std::abs(nees - dim) < 4 * std::sqrt(2.0 * dim / runs));
}

TEMPLATE_TEST_CASE("loop_gate: true loops are rejected at the stated rate, wrong ones are found", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>,
                   RelativePoseResidual<float>, RelativePoseYawResidual<float>, RelativeSim3Residual<float>) {
  using S = typename TestType::Scalar;
  constexpr int runs = 800;
  constexpr double rate = 0.05;
  int rejected = 0, rejected_inflated = 0, found = 0;
  for (int run = 0; run < runs; ++run) {
    SimulatedGraph<TestType> world(1000 + run, 30, {});
    const int i = run % 2 == 0 ? 2 : 28, j = 30 - i;  // in either order
    const auto Q = world.covariance(world.sigma_loop);
    auto loop = world.measure(i, j, world.sigma_loop, 1);
    const LoopGateResult result = test_loop(*world.graph, i, j, loop, Q, {.rejected_share = rate});
    REQUIRE(result.valid);
    rejected += result.accepted ? 0 : 1;
    const LoopGateOptions inflated{.rejected_share = rate, .covariance_inflation = 4};
    rejected_inflated += test_loop(*world.graph, i, j, loop, Q, inflated).accepted ? 0 : 1;
    Vec<S, TestType::dim> d = Vec<S, TestType::dim>::Zero();
    d[TestType::dim == 4 ? 1 : 3] = S(3);  // [m]
    loop = world.truth[i].inverse() * TestType::moved(world.truth[j], d);
    found += test_loop(*world.graph, i, j, loop, Q, {.rejected_share = 1e-3}).accepted ? 0 : 1;
  }
  REQUIRE(std::abs(rejected - rate * runs) < 4 * std::sqrt(rate * runs));
  REQUIRE(rejected_inflated < 0.2 * rate * runs);
  REQUIRE(found > 0.99 * runs);
}

TEST_CASE("loop_gate: bad input is not accepted") {
  using World = SimulatedGraph<RelativePoseResidual<double>>;
  World world(1, 10, {});
  const auto Q = World::covariance(world.sigma_loop);
  const SE3<double> loop = world.truth[2].inverse() * world.truth[8];
  REQUIRE(test_loop(*world.graph, 2, 8, loop, Q).accepted);
  for (const auto& [i, j] : {std::pair{-1, 3}, {3, 10}, {4, 4}}) REQUIRE(!test_loop(*world.graph, i, j, loop, Q).valid);
  const SE3<double> bad(loop.rotation(), Vec<double, 3>(NAN, 0, 0));
  REQUIRE(!test_loop(*world.graph, 2, 8, bad, Q).accepted);
  World::Covariance wrong = Q;
  wrong(0, 0) = -1;
  REQUIRE(!test_loop(*world.graph, 2, 8, loop, wrong).valid);
  wrong(0, 0) = NAN;
  REQUIRE(!test_loop(*world.graph, 2, 8, loop, wrong).accepted);
  const SE3<double> huge(loop.rotation(), Vec<double, 3>(1e200, 0, 0));
  REQUIRE(!test_loop(*world.graph, 2, 8, huge, Q).accepted);
}
