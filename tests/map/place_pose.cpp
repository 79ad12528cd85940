// The pose of a camera in an older keyframe: exact, consistent, in other units, and refused where there is none.
#include "plumbline/map/place_pose.hpp"

#include <limits>
#include <memory>

#include "catch.hpp"
#include "simulated_places.hpp"

using namespace plumbline;
using test::looking_along;

namespace {

template <class S>
struct Pair {
  using Solver = PlacePoseSolver<S, 200>;
  std::unique_ptr<Solver> solver = std::make_unique<Solver>();
  PlaceKeyframe<S, 200> old, current;
  SE3<double> T_old_current;

  Pair(test::SimulatedPlaces& places, double turned, const Vec<double, 3>& moved, double scale = 1) {
    const SE3<double> T_old = looking_along(0.3, {0, 0, 0}), T_current = looking_along(0.3 + turned, moved);
    places.look(T_old, old.features);
    places.look(T_current, current.features, scale);
    T_old_current = T_old.inverse() * T_current;
  }
  const PlacePose<S>& solve() { return solver->solve(old, current, SE3<S>(), {}); }
};

}  // namespace

TEMPLATE_TEST_CASE("place_pose: without noise it is exact", "", float, double) {
  test::SimulatedPlaces places(3);
  places.sigma_rad = 1e-5;
  places.relative_sigma_range = 1e-5;
  places.furnish(400, 4);
  Pair<TestType> pair(places, 0.2, {0.3, -0.2, 0.1});
  const PlacePose<TestType>& found = pair.solve();
  REQUIRE(found.valid);
  const SE3<double> error = pair.T_old_current.inverse() * found.T_old_current.template cast<double>();
  CHECK(norm(error.p()) < 1e-4);
  CHECK(norm(error.rotation().log()) < 1e-4);
  CHECK(std::abs(double(found.log_scale)) < 1e-3);
}

TEST_CASE("place_pose: its covariance is that of its errors") {
  double nees = 0;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    test::SimulatedPlaces places(seed);
    places.furnish(400, 4);
    Pair<double> pair(places, 0.25, {0.4, 0.3, -0.1});
    const PlacePose<double>& pose = pair.solve();
    if (!pose.valid) continue;
    ++found;
    const SE3<double> error = pair.T_old_current.inverse() * pose.T_old_current;
    Vec<double, 6> e;
    set_segment(e, 0, error.rotation().log());
    set_segment(e, 3, error.p());
    const Result<Mat<double, 6, 6>> L = square_root_information(pose.covariance);
    REQUIRE(L);
    nees += squared_norm(Vec<double, 6>(times(*L, e)));
  }
  REQUIRE(found >= 58);
  CHECK(nees / found > 3);  // 6 expected
  CHECK(nees / found < 9);
}

TEST_CASE("place_pose: the scale of the current world in the older one") {
  test::SimulatedPlaces places(4);
  places.furnish(400, 4);
  Pair<double> pair(places, 0.1, {0.2, 0.1, 0}, 2.5);
  const PlacePose<double>& found = pair.solve();
  REQUIRE(found.valid);
  CHECK(std::abs(found.log_scale + std::log(2.5)) < 4 * found.log_scale_sigma + 0.002);
  CHECK(found.log_scale_sigma < 0.01);
}

TEST_CASE("place_pose: another place gives none, nor does nothing, nor NaN") {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    test::SimulatedPlaces here(seed), there(seed + 100);
    here.furnish(400, 4);
    there.furnish(400, 4);
    Pair<double> a(here, 0, {0, 0, 0}), b(there, 0.1, {0, 0, 0});
    a.current = b.current;
    CHECK_FALSE(a.solve().valid);
  }
  test::SimulatedPlaces places(1);
  places.furnish(400, 4);
  Pair<double> pair(places, 0.1, {0.1, 0, 0});
  REQUIRE(pair.solve().valid);
  Pair<double> empty = {places, 0.1, {0.1, 0, 0}};
  empty.current.features.clear();
  CHECK_FALSE(empty.solve().valid);
  for (auto& feature : pair.old.features) feature.range = std::numeric_limits<float>::quiet_NaN();
  CHECK_FALSE(pair.solve().valid);
}
