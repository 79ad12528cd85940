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

TEMPLATE_TEST_CASE("pose_graph: odometry is replaced, bad one refused", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<float>, RelativeSim3Residual<double>) {
  using S = typename TestType::Scalar;
  using In = PoseGraphInsertion;
  SimulatedGraph<TestType> world(3, 10, {});
  auto& graph = *world.graph;
  const auto Q = world.covariance(world.sigma_loop), before = graph.odometry(4).covariance();
  const auto measured = world.measure(3, 4, world.sigma_loop, 0);
  const auto pose = test::numbers(graph.pose(4));
  auto wrong = Q;
  wrong(1, 1) = S(-1);
  for (const int node : {-1, 0, 10}) REQUIRE(graph.set_odometry(node, measured, Q) == In::no_such_node);
  REQUIRE(graph.set_odometry(4, measured, wrong) == In::not_positive_definite);
  wrong(1, 1) = std::numeric_limits<S>::infinity();
  REQUIRE(graph.set_odometry(4, measured, wrong) == In::not_finite);
  REQUIRE(graph.odometry(4).covariance() == before);
  REQUIRE(graph.set_odometry(4, measured, Q) == In::inserted);
  REQUIRE(test::numbers(graph.odometry(4).residual.measured) == test::numbers(measured));
  REQUIRE((graph.odometry(4).covariance() - Q).norm() < S(1e-5) * Q.norm());
  REQUIRE(test::numbers(graph.pose(4)) == pose);
}

TEMPLATE_TEST_CASE("pose_graph: a composed and an inverse edge have the covariance of their samples", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  using World = SimulatedGraph<TestType>;
  using Vector = typename World::Vector;
  constexpr int dim = TestType::dim, samples = 20000;
  World world(8, 3, {});
  const auto& first = world.graph->odometry(1);
  const auto& second = world.graph->odometry(2);
  const auto T0 = world.truth[0];
  const auto composed = first.composed(T0, second), inverse = first.inverse(T0);
  REQUIRE(composed);
  REQUIRE(inverse);
  typename World::Covariance P_composed = World::Covariance::Zero(), P_inverse = P_composed;
  const auto increment = [&] {
    Vector d;
    for (int n = 0; n < dim; ++n) d[n] = world.sigma_odometry[n] * world.noise();
    return d;
  };
  const auto T1 = T0 * first.residual.measured, T2 = T1 * second.residual.measured;
  for (int n = 0; n < samples; ++n) {  // in the frame of the map: the increments of one mode turn about its vertical
    const auto T1_n = TestType::moved(T1, increment());
    const auto step = T1.inverse() * TestType::moved(T2, increment());
    const Vector d = composed->residual.residual(T0, T1_n * step), e = inverse->residual.residual(T1_n, T0);
    P_composed += d * d.transpose() / samples;
    P_inverse += e * e.transpose() / samples;
  }
  REQUIRE((composed->covariance() - P_composed).norm() < 0.05 * P_composed.norm());
  REQUIRE((inverse->covariance() - P_inverse).norm() < 0.05 * P_inverse.norm());
  const auto back = inverse->inverse(T1);
  REQUIRE(back);
  REQUIRE((back->covariance() - first.covariance()).norm() < 1e-9 * first.covariance().norm());
}

TEMPLATE_TEST_CASE("pose_graph: a node is removed, its edges merge and its loops move", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>,
                   RelativePoseResidual<float>) {
  using S = typename TestType::Scalar;
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-9;
  for (const int node : {0, 1, 12, 24, 28, 29}) {
    // Exact measurements: whatever is removed, all residuals stay zero.
    SimulatedGraph<TestType> world(1, 30, {{0, 24}, {24, 5}, {12, 13}, {12, 11}, {29, 2}, {28, 29}, {1, 0}}, 0);
    auto& graph = *world.graph;
    const double det_12 = double(graph.odometry(12).L.determinant());
    REQUIRE(graph.remove_node(node));
    REQUIRE(graph.nodes() == 29);
    REQUIRE(graph.loops() == (node == 0 || node == 29 ? 6 : 7));  // (1, 0) and (28, 29) have no other neighbor
    auto truth = world.truth;
    truth.erase(truth.begin() + node);
    for (int k = 0; k < 29; ++k) REQUIRE(double(world.error(k < node ? k : k + 1, graph.pose(k)).norm()) < tolerance);
    for (int k = 1; k < 29; ++k) {
      REQUIRE(double(graph.odometry(k).residual.residual(truth[k - 1], truth[k]).norm()) < tolerance);
    }
    for (int l = 0; l < graph.loops(); ++l) {
      const auto& loop = graph.loop(l);
      REQUIRE((loop.i >= 0 && loop.j >= 0 && loop.i < 29 && loop.j < 29 && loop.i != loop.j));
      REQUIRE(double(loop.edge.residual.residual(truth[loop.i], truth[loop.j]).norm()) < tolerance);
    }
    if (node == 12) REQUIRE(double(graph.odometry(12).L.determinant()) < det_12);
  }
}

TEMPLATE_TEST_CASE("pose_graph: a moved loop has the covariance of its samples, either end, either way", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  using World = SimulatedGraph<TestType>;
  constexpr int samples = 10000;
  for (const bool to_before : {true, false}) {
    World world(4, 30, {{10, 24}, {24, 12}}, 0);
    auto& graph = *world.graph;
    const auto& truth = world.truth;
    const auto T_before = truth[22].inverse() * truth[23];
    const auto T_23_24 = truth[23].inverse() * truth[24], T_24_25 = truth[24].inverse() * truth[25];
    const auto Q = world.covariance(world.sigma_odometry), certain = typename World::Covariance(0.9 * Q);
    REQUIRE(graph.set_odometry(23, T_before, Q) == PoseGraphInsertion::inserted);
    REQUIRE(graph.set_odometry(24, T_23_24, to_before ? certain : Q) == PoseGraphInsertion::inserted);
    REQUIRE(graph.set_odometry(25, T_24_25, to_before ? Q : certain) == PoseGraphInsertion::inserted);
    REQUIRE(graph.remove_node(24));
    const int m = to_before ? 23 : 24;  // the index of the neighbor now
    REQUIRE(graph.loop(0).i == 10);
    REQUIRE(graph.loop(0).j == m);
    REQUIRE(graph.loop(1).i == m);
    REQUIRE(graph.loop(1).j == 12);
    const auto moved_by = [&](int k, const typename World::Vector& sigma, double factor) {
      typename World::Vector d;
      for (int n = 0; n < TestType::dim; ++n) d[n] = factor * sigma[n] * world.noise();
      return TestType::moved(truth[k], d);
    };
    typename World::Covariance P_j = World::Covariance::Zero(), P_i = P_j;
    for (int n = 0; n < samples; ++n) {
      const auto step = to_before ? (truth[23].inverse() * moved_by(24, world.sigma_odometry, std::sqrt(0.9))).inverse()
                                  : truth[24].inverse() * moved_by(25, world.sigma_odometry, std::sqrt(0.9));
      const auto T_j = moved_by(24, world.sigma_loop, 1) * step, T_i = truth[24] * step;
      const auto d_j = graph.loop(0).edge.residual.residual(truth[10], T_j);
      const auto d_i = graph.loop(1).edge.residual.residual(T_i, moved_by(12, world.sigma_loop, 1));
      P_j += d_j * d_j.transpose() / samples;
      P_i += d_i * d_i.transpose() / samples;
    }
    REQUIRE((graph.loop(0).edge.covariance() - P_j).norm() < 0.06 * P_j.norm());
    REQUIRE((graph.loop(1).edge.covariance() - P_i).norm() < 0.06 * P_i.norm());
  }
}

TEMPLATE_TEST_CASE("pose_graph: without a node that no loop touches, the solution is the same", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  SimulatedGraph<TestType> world(6, 46, loops_of_two_laps);
  const auto all = solve<NoLoss>(world);
  // Composition is exact to first order: linearized at the solution of all nodes.
  world.graph->set_poses(46, [&](int k) { return all->pose(k); });
  REQUIRE(world.graph->remove_node(35));
  REQUIRE(world.graph->remove_node(17));
  const auto fewer = solve<NoLoss>(world);
  REQUIRE(fewer->summary().final_cost == Approx(all->summary().final_cost).epsilon(0.05));
  const auto P = all->newest_covariance();
  REQUIRE((fewer->newest_covariance() - P).norm() < 0.02 * P.norm());
  const Vec<double, TestType::dim> d =
      TestType{world.truth[0].inverse() * fewer->pose(43)}.residual(world.truth[0], all->pose(45));
  REQUIRE(d.dot(P.ldlt().solve(d)) < 0.01);  // a tenth of its sigma
}

TEMPLATE_TEST_CASE("pose_graph: a moved loop corrects the drift as before", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  SimulatedGraph<TestType> world(6, 46, loops_of_two_laps);
  const auto all = solve(world);
  REQUIRE(world.graph->set_odometry(24, world.graph->odometry(24).residual.measured,
                                    1e-4 * world.covariance(world.sigma_odometry)) == PoseGraphInsertion::inserted);
  REQUIRE(world.graph->remove_node(24));
  REQUIRE(world.graph->loop(0).j == 23);  // the more certain edge is the one to node 23
  const auto fewer = solve(world);
  const auto P = all->newest_covariance();
  REQUIRE((fewer->newest_covariance() - P).norm() < 0.1 * P.norm());
  REQUIRE(double(world.error(45, fewer->pose(44)).norm()) < 0.02 + 1.5 * world.error(45, all->pose(45)).norm());
}

TEST_CASE("pose_graph: the only node stays, and two become one") {
  PoseGraph<RelativePoseResidual<double>, 3, 2> graph;
  const Mat<double, 6, 6> Q = Mat<double, 6, 6>::Identity();
  const SE3<double> T(SO3<double>(), Vec<double, 3>(1, 2, 3));
  REQUIRE(!graph.remove_node(0));
  REQUIRE(graph.add_first({}) == PoseGraphInsertion::inserted);
  REQUIRE(!graph.remove_node(0));
  REQUIRE(graph.add_node(T, Q) == PoseGraphInsertion::inserted);
  REQUIRE(graph.add_loop(0, 1, T, Q) == PoseGraphInsertion::inserted);
  REQUIRE(!graph.remove_node(2));
  REQUIRE(!graph.remove_node(-1));
  REQUIRE(graph.remove_node(0));
  REQUIRE(graph.nodes() == 1);
  REQUIRE(graph.loops() == 0);
  REQUIRE(graph.pose(0).p() == T.p());
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
