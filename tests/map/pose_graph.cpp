// map/pose_graph.hpp and map/pose_graph_solver.hpp
#include "plumbline/map/pose_graph.hpp"

#include <Eigen/Cholesky>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "map/simulated_graph.hpp"
#include "plumbline/map/pose_graph_solver.hpp"

using namespace plumbline;
using test::SimulatedGraph;

namespace {

const std::vector<test::LoopEnd> loops_of_two_laps = {{0, 24}, {5, 29}, {31, 8}, {12, 13}, {8, 40}, {20, 44}};
const LevenbergMarquardtOptions thorough = {
    .max_iterations = 100, .relative_cost_tolerance = 1e-13, .step_tolerance = 1e-10};

template <template <class> class Loss = Cauchy, class World>
auto solve(const World& world, int budget = 1'000'000'000) {
  auto solver = std::make_unique<PoseGraphSolver<typename World::Graph, Loss>>();
  solver->begin(*world.graph, thorough);
  while (!solver->iterate(budget)) {
  }
  return solver;
}

/// Dense Gauss-Newton information matrix and gradient over all nodes but the first one.
template <class World, class Solver>
std::pair<Eigen::MatrixXd, Eigen::VectorXd> dense_equations(const World& world, const Solver& solver) {
  constexpr int dim = World::Residual::dim;
  const int nodes = world.graph->nodes();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dim * nodes, dim * nodes);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(dim * nodes);
  const auto add = [&](int i, int j, const typename World::Graph::Edge& edge, bool robust) {
    const auto lin = edge.residual.linearize(solver.pose(i), solver.pose(j));
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dim, dim * nodes);
    J.middleCols(dim * i, dim) = (edge.L * lin.J_r_i).template cast<double>();
    J.middleCols(dim * j, dim) = (edge.L * lin.J_r_j).template cast<double>();
    const Eigen::VectorXd r = (edge.L * lin.r).template cast<double>();
    const double w = robust ? Solver::default_loss().weight(r.squaredNorm()) : 1;
    H += w * J.transpose() * J;
    b += w * J.transpose() * r;
  };
  for (int k = 1; k < nodes; ++k) add(k - 1, k, world.graph->odometry(k), false);
  for (int l = 0; l < world.graph->loops(); ++l) {
    add(world.graph->loop(l).i, world.graph->loop(l).j, world.graph->loop(l).edge, true);
  }
  const int n = dim * (nodes - 1);
  return {H.bottomRightCorner(n, n), b.tail(n)};
}

}  // namespace

TEMPLATE_TEST_CASE("pose_graph: exact measurements give the truth", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>, RelativePoseResidual<float>,
                   RelativePoseYawResidual<float>, RelativeSim3Residual<float>) {
  using S = typename TestType::Scalar;
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-8;
  SimulatedGraph<TestType> world(1, 50, loops_of_two_laps, 0);
  testing::Gaussian noise(3);  // the initial poses are wrong
  world.graph->set_poses(50, [&](int k) {
    Vec<S, TestType::dim> d;
    for (int n = 0; n < TestType::dim; ++n) d[n] = S(k == 0 ? 0 : 0.1 * noise());
    return TestType::moved(world.truth[k], d);
  });
  const auto solver = solve(world);
  if (std::is_same_v<S, double>) REQUIRE(solver->summary().termination == LevenbergMarquardtEnd::converged);
  REQUIRE(solver->summary().termination != LevenbergMarquardtEnd::not_finite);  // float ends at its rounding
  REQUIRE(solver->summary().initial_cost > 1000);
  REQUIRE(solver->summary().final_cost < (std::is_same_v<S, float> ? 1e-3 : 1e-10));
  for (int k = 0; k < 50; ++k) REQUIRE(double(world.error(k, solver->pose(k)).norm()) < tolerance);
}

TEMPLATE_TEST_CASE("pose_graph: errors agree with the covariance", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>, RelativePoseResidual<float>) {
  using World = SimulatedGraph<TestType>;
  constexpr int runs = 60, dim = TestType::dim;
  double nees = 0, cost = 0, odometry = 0, corrected = 0;
  for (int run = 0; run < runs; ++run) {
    const World world(100 + run, 46, loops_of_two_laps);
    const auto solver = solve<NoLoss>(world);
    REQUIRE(solver->covariance_valid());
    const Vec<double, dim> e = world.error(45, solver->pose(45)).template cast<double>();
    const Mat<double, dim, dim> P = solver->newest_covariance();
    nees += e.dot(P.ldlt().solve(e)) / runs;
    cost += 2 * solver->summary().final_cost / runs;
    odometry += double(world.error(45, world.graph->pose(45)).norm()) / runs;
    corrected += e.norm() / runs;
  }
  REQUIRE(std::abs(nees - dim) < 4 * std::sqrt(2.0 * dim / runs));
  const int dof = dim * int(loops_of_two_laps.size());  // rows minus unknowns
  REQUIRE(std::abs(cost - dof) < 4 * std::sqrt(2.0 * dof / runs));
  REQUIRE(corrected < 0.8 * odometry);
}

TEMPLATE_TEST_CASE("pose_graph: covariance and gradient are those of the dense equations", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  constexpr int dim = TestType::dim;
  const std::vector<std::vector<test::LoopEnd>> cases = {
      {}, {{0, 29}}, {{29, 3}}, {{1, 2}, {2, 1}}, {{1, 28}, {28, 0}, {5, 20}, {7, 22}, {21, 6}, {5, 28}, {10, 11}}};
  for (const auto& loops : cases) {
    const SimulatedGraph<TestType> world(7, 30, loops);
    const auto solver = solve(world);
    const auto [H, b] = dense_equations(world, *solver);
    const Eigen::MatrixXd P = H.ldlt().solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
    const Eigen::MatrixXd newest = P.bottomRightCorner(dim, dim);
    REQUIRE(solver->covariance_valid());
    REQUIRE((solver->newest_covariance() - newest).norm() < 1e-9 * newest.norm());
    REQUIRE(b.dot(P * b) < 1e-10 * (1 + solver->summary().final_cost));  // squared distance to the minimum, in sigma
  }
}

TEMPLATE_TEST_CASE("pose_graph: float agrees with double", "", RelativePoseResidual<float>,
                   RelativePoseYawResidual<float>, RelativeSim3Residual<float>) {
  const SimulatedGraph<TestType> world(9, 46, loops_of_two_laps);
  using Exact = std::conditional_t<
      TestType::dim == 4, RelativePoseYawResidual<double>,
      std::conditional_t<TestType::dim == 6, RelativePoseResidual<double>, RelativeSim3Residual<double>>>;
  const SimulatedGraph<Exact> exact(9, 46, loops_of_two_laps);
  auto solver = std::make_unique<PoseGraphSolver<typename SimulatedGraph<TestType>::Graph>>();
  solver->begin(*world.graph);  // with the default options
  while (!solver->iterate(1000)) {
  }
  const auto expected = solve(exact);
  REQUIRE(solver->summary().termination == LevenbergMarquardtEnd::converged);
  REQUIRE(solver->summary().iterations < 10);
  REQUIRE(solver->summary().final_cost == Approx(expected->summary().final_cost).epsilon(1e-3));
  REQUIRE((solver->newest_covariance() - expected->newest_covariance()).norm() <
          1e-2 * expected->newest_covariance().norm());
  for (int k = 0; k < 46; ++k) REQUIRE(exact.error(k, solver->pose(k).template cast<double>()).norm() < 0.3);
}

TEMPLATE_TEST_CASE("pose_graph: the first node is the gauge", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  const SimulatedGraph<TestType> world(11, 46, loops_of_two_laps);
  const auto solver = solve(world);
  SimulatedGraph<TestType> moved(11, 46, loops_of_two_laps);
  const Vec<double, 3> axis = TestType::dim == 4 ? Vec<double, 3>(0, 0, 2) : Vec<double, 3>(0.7, -1, 2);
  const auto G = test::make_pose<TestType>(SO3<double>::exp(axis), Vec<double, 3>(30, -20, 5), 2.5);
  moved.graph->set_poses(46, [&](int k) { return G * world.graph->pose(k); });
  const auto solver_moved = solve(moved);
  REQUIRE(solver->summary().final_cost == Approx(solver_moved->summary().final_cost).epsilon(1e-10));
  for (int k = 0; k < 46; ++k) {
    const auto difference = TestType{world.truth[0].inverse() * solver->pose(k)}.residual(
        world.truth[0], G.inverse() * solver_moved->pose(k));
    REQUIRE(difference.norm() < 1e-6);
  }
  REQUIRE(test::numbers(solver->pose(0)) == test::numbers(world.graph->pose(0)));
}

TEMPLATE_TEST_CASE("pose_graph: a wrong loop is rejected by the robust kernel", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>, RelativePoseYawResidual<float>) {
  using S = typename TestType::Scalar;
  SimulatedGraph<TestType> world(5, 46, loops_of_two_laps);
  const auto without = solve(world);
  Vec<S, TestType::dim> d = Vec<S, TestType::dim>::Constant(S(0.5));
  d[1] = S(2.5);
  const auto wrong = world.truth[3].inverse() * TestType::moved(world.truth[36], d);
  REQUIRE(world.graph->add_loop(3, 36, wrong, world.covariance(world.sigma_loop)) == PoseGraphInsertion::inserted);
  const auto solver = solve(world);
  REQUIRE(solver->chi2(6) > 1000);
  REQUIRE(solver->weight(6) < 0.01);
  for (int l = 0; l < 6; ++l) REQUIRE(solver->chi2(l) < 30);
  for (int k = 0; k < 46; ++k) {
    REQUIRE(double(world.error(k, solver->pose(k)).norm()) <
            0.03 + 2 * double(world.error(k, without->pose(k)).norm()));
  }
  world.graph->remove_loop(6);
  REQUIRE(solve(world)->summary().final_cost == without->summary().final_cost);
  // Least squares is bent by it.
  REQUIRE(world.graph->add_loop(3, 36, wrong, world.covariance(world.sigma_loop)) == PoseGraphInsertion::inserted);
  const auto bent = solve<NoLoss>(world);
  REQUIRE(double(world.error(36, bent->pose(36)).norm()) > 0.3);
}

TEMPLATE_TEST_CASE("pose_graph: slices give the same bits as one call", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<float>, RelativeSim3Residual<double>) {
  const SimulatedGraph<TestType> world(2, 46, loops_of_two_laps);
  const auto at_once = solve(world);
  for (const int budget : {1, 7, 100}) {
    auto solver = std::make_unique<PoseGraphSolver<typename SimulatedGraph<TestType>::Graph>>();
    solver->begin(*world.graph, thorough);
    int slices = 1;
    while (!solver->iterate(budget)) ++slices;
    REQUIRE(slices > 500 / budget);
    REQUIRE(solver->summary().iterations == at_once->summary().iterations);
    REQUIRE(solver->summary().final_cost == at_once->summary().final_cost);
    REQUIRE(solver->newest_covariance() == at_once->newest_covariance());
    for (int k = 0; k < 46; ++k) {
      REQUIRE(test::numbers(solver->pose(k)) == test::numbers(at_once->pose(k)));
    }
  }
}

TEST_CASE("pose_graph: nodes that come while it is solved move with the last one") {
  using Residual = RelativePoseResidual<double>;
  SimulatedGraph<Residual> world(4, 46, loops_of_two_laps);
  const auto expected = solve(world);
  auto solver = std::make_unique<PoseGraphSolver<SimulatedGraph<Residual>::Graph>>();
  solver->begin(*world.graph, thorough);
  bool done = solver->iterate(50);
  REQUIRE(!done);
  const SE3<double> step(SO3<double>::exp({0.1, 0, 0.2}), Vec<double, 3>(1, 2, 3));
  REQUIRE(world.graph->add_node(step, world.covariance(world.sigma_odometry)) == PoseGraphInsertion::inserted);
  while (!done) done = solver->iterate(50);
  REQUIRE(solver->nodes() == 46);
  REQUIRE(solver->summary().final_cost == expected->summary().final_cost);
  world.graph->set_poses(solver->nodes(), [&](int k) { return solver->pose(k); });
  REQUIRE(minus(world.graph->pose(46), solver->pose(45) * step).norm() < 1e-12);
}

TEMPLATE_TEST_CASE("pose_graph: bad input is refused and changes nothing", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<float>) {
  using S = typename TestType::Scalar;
  using Graph = PoseGraph<TestType, 3, 1>;
  using In = PoseGraphInsertion;
  const S nan = std::numeric_limits<S>::quiet_NaN(), inf = std::numeric_limits<S>::infinity();
  const auto good = test::make_pose<TestType>({}, Vec<double, 3>(1, 2, 3)),
             bad = test::make_pose<TestType>({}, Vec<double, 3>(1, double(nan), 3));
  typename Graph::Covariance Q = Graph::Covariance::Identity(), wrong = Q;
  Graph graph;
  REQUIRE(graph.add_node(good, Q) == In::no_such_node);
  REQUIRE(graph.add_first(bad) == In::not_finite);
  REQUIRE(graph.add_first(good) == In::inserted);
  REQUIRE(graph.add_node(bad, Q) == In::not_finite);
  REQUIRE(graph.add_node(bad, good, Q) == In::not_finite);
  for (const S number : {nan, inf, S(-1), S(0)}) {
    wrong(2, 2) = number;
    const In expected = std::isfinite(number) ? In::not_positive_definite : In::not_finite;
    REQUIRE(graph.add_node(good, wrong) == expected);
  }
  REQUIRE(graph.nodes() == 1);
  REQUIRE(graph.add_node(good, Q) == In::inserted);
  REQUIRE(graph.add_node(good, Q) == In::inserted);
  REQUIRE(graph.add_node(good, Q) == In::full);
  REQUIRE(graph.add_loop(0, 3, good, Q) == In::no_such_node);
  REQUIRE(graph.add_loop(-1, 1, good, Q) == In::no_such_node);
  REQUIRE(graph.add_loop(1, 1, good, Q) == In::no_such_node);
  REQUIRE(graph.add_loop(0, 2, bad, Q) == In::not_finite);
  REQUIRE(graph.add_loop(0, 2, good, wrong) == In::not_positive_definite);
  REQUIRE(graph.loops() == 0);
  REQUIRE(graph.add_loop(0, 2, good, Q) == In::inserted);
  REQUIRE(graph.add_loop(0, 2, good, Q) == In::full);
  Q(1, 0) = Q(0, 1) = S(0.5);
  REQUIRE(graph.add_first(good) == In::inserted);
  REQUIRE(graph.add_node(good, Q) == In::inserted);
  REQUIRE((graph.odometry(1).covariance() - Q).norm() < S(1e-5));
}

TEST_CASE("pose_graph: nothing to solve, and numbers that overflow") {
  using Graph = PoseGraph<RelativePoseResidual<double>, 4, 2>;
  Graph graph;
  PoseGraphSolver<Graph> solver;
  REQUIRE(solver.done());
  REQUIRE(graph.add_first({}) == PoseGraphInsertion::inserted);
  solver.begin(graph);
  REQUIRE(solver.iterate(1));
  REQUIRE(solver.summary().termination == LevenbergMarquardtEnd::converged);
  REQUIRE(solver.covariance_valid());
  REQUIRE(solver.newest_covariance().norm() == 0);

  const SE3<double> huge(SO3<double>(), Vec<double, 3>(1e200, 0, 0));
  REQUIRE(graph.add_node(huge, {}, Graph::Covariance::Identity()) == PoseGraphInsertion::inserted);
  solver.begin(graph);
  while (!solver.iterate(10)) {
  }
  REQUIRE(solver.summary().termination == LevenbergMarquardtEnd::not_finite);
  REQUIRE(!solver.covariance_valid());
  REQUIRE(solver.pose(1).p() == huge.p());
}
