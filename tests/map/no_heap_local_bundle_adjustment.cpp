// A local bundle adjustment does not allocate: fill, begin, solve in slices, clear.
#include "allocation_counter.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/map/local_bundle_adjustment.hpp"
#include "plumbline/testing/simulated_bundle.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("no heap: local bundle adjustment", "", float, double) {
  testing::SimulatedBundleOptions options;
  options.range_share = 0.3;
  options.edges = true;
  options.lines = 10;
  const testing::SimulatedBundle world(options);
  const auto solver = std::make_unique<LocalBundleAdjustment<TestType, 10, 200, 2000, 20, 10>>();
  bool filled = true, inlier = false;
  const long allocations = test::allocations_of([&] {
    for (int run = 0; run < 2; ++run) {
      solver->clear();
      filled = filled && world.fill<TestType>(*solver);
      solver->begin();
      while (!solver->iterate(100)) {
      }
      inlier = solver->is_inlier(0);
    }
  });
  CHECK(allocations == 0);
  CHECK(filled);
  CHECK(inlier);
  CHECK(solver->cost() < TestType(0.2) * solver->initial_cost());
}
