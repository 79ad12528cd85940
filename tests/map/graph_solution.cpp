#include "plumbline/map/graph_solution.hpp"

#include <memory>

#include "catch.hpp"
#include "straight_places.hpp"

using namespace plumbline;
using test::along_x;
using test::StraightPlaces;

namespace {

using Places = StraightPlaces::Places;

/// Keyframes whose last one is, by a loop, a tenth of a meter before where the odometry has it; the solution has begun.
struct Run : StraightPlaces {
  std::unique_ptr<GraphSolution<Places>> solution = std::make_unique<GraphSolution<Places>>();
  MapCorrection<Places> correction;

  Run() {
    drive(6);
    REQUIRE(places->graph().add_loop(0, 5, along_x(4.9), test::isotropic(1e-5)) == PoseGraphInsertion::inserted);
    solution->begin(*places);
  }
  int solve(int budget) {
    int slices = 1;
    while (!solution->iterate(budget)) REQUIRE(++slices < 10000);
    return slices;
  }
  double x_in_map(double x_world) const { return (places->S_map_world() * Vec<double, 3>(x_world, 0, 0)).x(); }
};

}  // namespace

TEST_CASE("graph_solution: the map takes the poses of the solution, and the world its place in it") {
  Run run;
  run.solve(1000000);
  CHECK(run.places->graph().pose(5).p().x() == 5);  // nothing changes before it is applied
  REQUIRE(run.solution->apply(*run.places, run.correction));
  CHECK(run.places->graph().pose(5).p().x() == Approx(4.9).epsilon(1e-3));
  CHECK(run.x_in_map(5) == Approx(run.places->graph().pose(5).p().x()).epsilon(1e-12));
  Places::Covariance P;
  CHECK(run.correction.covariance(*run.places, 5, P));
  CHECK_FALSE(run.correction.covariance(*run.places, 4, P));  // it ends with the newest keyframe
}

TEST_CASE("graph_solution: in slices it is the same as at once") {
  Run at_once, sliced;
  const int slices = sliced.solve(1);
  CHECK(slices > 5);
  CHECK(at_once.solve(1000000) < slices);
  REQUIRE(at_once.solution->apply(*at_once.places, at_once.correction));
  REQUIRE(sliced.solution->apply(*sliced.places, sliced.correction));
  for (int k = 0; k < 6; ++k) CHECK(at_once.places->graph().pose(k).p() == sliced.places->graph().pose(k).p());
}

TEST_CASE("graph_solution: keyframes that came since move with the newest one that was solved for") {
  Run run;
  run.drive(2, 6);
  run.solve(1000000);
  REQUIRE(run.solution->apply(*run.places, run.correction));
  const double newest = run.places->graph().pose(5).p().x();
  CHECK(run.places->graph().pose(7).p().x() == Approx(newest + 2).epsilon(1e-9));
  CHECK(run.x_in_map(7) == Approx(newest + 2).epsilon(1e-9));
}

TEST_CASE("graph_solution: that of a world which has ended is not applied") {
  Run run;
  run.solve(1000000);
  run.places->begin_world();
  CHECK_FALSE(run.solution->apply(*run.places, run.correction));
  CHECK(run.places->graph().pose(5).p().x() == 5);
  CHECK(run.x_in_map(5) == 5);
  Places::Covariance P;
  CHECK_FALSE(run.correction.covariance(*run.places, 5, P));
}
