// The pose graph and the gate of its loops do not allocate.
#include "allocation_counter.hpp"

#include <memory>

#include "catch.hpp"
#include "map/simulated_graph.hpp"
#include "plumbline/map/loop_gate.hpp"
#include "plumbline/map/pose_graph_solver.hpp"

using namespace plumbline;
using test::allocations_of;

TEMPLATE_TEST_CASE("no_heap: insertion, gate and solution", "", RelativePoseResidual<float>,
                   RelativePoseResidual<double>, RelativePoseYawResidual<float>, RelativePoseYawResidual<double>,
                   RelativeSim3Residual<float>, RelativeSim3Residual<double>) {
  using World = test::SimulatedGraph<TestType>;
  World world(1, 50, {{0, 24}, {5, 29}, {8, 40}});
  const auto solver = std::make_unique<PoseGraphSolver<typename World::Graph>>();
  bool ok = true;
  const long count = allocations_of([&] {
    const auto Q = World::covariance(world.sigma_loop);
    const auto loop = world.measure(12, 37, world.sigma_loop, 1);
    ok = ok && test_loop(*world.graph, 12, 37, loop, Q).valid;
    ok = ok && world.graph->add_loop(12, 37, loop, Q) == PoseGraphInsertion::inserted;
    ok = ok && world.graph->add_node(loop, Q) == PoseGraphInsertion::inserted;
    solver->begin(*world.graph);
    while (!solver->iterate(10)) {
    }
    world.graph->set_poses(solver->nodes(), [&](int k) { return solver->pose(k); });
    ok = ok && world.graph->set_odometry(3, loop, Q) == PoseGraphInsertion::inserted && world.graph->remove_node(12);
  });
  REQUIRE(ok);
  REQUIRE(solver->covariance_valid());
  REQUIRE(count == 0);
}
