#include "plumbline/start/two_view.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

namespace {

template <class S, bool knows_rotation>
void add_pairs(const TwoViewScene& scene, TwoViewStart<S, knows_rotation>& start) {
  for (const BearingPair<double>& pair : scene.pairs) {
    start.add_pair(pair.f1.template cast<S>(), pair.f2.template cast<S>());
  }
}

}  // namespace

TEMPLATE_TEST_CASE("two_view: a second view from aside is found, a fifth of the unit away", "", float, double) {
  using S = TestType;
  TwoViewStartOptions options;
  options.min_parallax_rad = 0.02;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoViewScene scene(TwoViewKind::general, seed, TwoViewScene::pixel / 2, 0.1);
    TwoViewStart<S, true> start(options);
    add_pairs(scene, start);
    REQUIRE(start.pairs() == int(scene.pairs.size()));
    InitReport report;
    const bool found = start.solve(scene.T_2_1.rotation().template cast<S>(), report);
    CAPTURE(seed, name_of(report.stage), report.parallax_rad, report.inliers);
    REQUIRE(found);
    REQUIRE(report.parallax_rad > options.min_parallax_rad);
    REQUIRE((report.inliers > 0.8 && report.inliers <= 1));
    const SE3<S> T_2_1 = start.T_1_2().inverse();
    REQUIRE(double(T_2_1.p().norm()) == Approx(0.2));
    REQUIRE(scene.rotation_error(T_2_1) < 0.01);
    REQUIRE(scene.direction_error(T_2_1) < 0.1);
  }
}

TEST_CASE("two_view: a camera that only turns waits for parallax") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoViewScene scene(TwoViewKind::rotation, seed, TwoViewScene::pixel, 0.1);
    TwoViewStart<double, true> start({});
    add_pairs(scene, start);
    InitReport report{.stage = InitStage::little_parallax};
    REQUIRE(!start.solve(scene.T_2_1.rotation(), report));
    REQUIRE(report.stage == InitStage::little_parallax);
    REQUIRE(report.parallax_rad < TwoViewStartOptions{}.min_parallax_rad);
  }
}

TEST_CASE("two_view: pairs of which half are wrong are no second view") {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoViewScene scene(TwoViewKind::general, seed, TwoViewScene::pixel, 0.5);
    TwoViewStart<double, true> start({});
    add_pairs(scene, start);
    InitReport report{.stage = InitStage::little_parallax};
    REQUIRE(!start.solve(scene.T_2_1.rotation(), report));
    REQUIRE(report.inliers < TwoViewStartOptions{}.min_inliers);
  }
}

TEST_CASE("two_view: a first view expires when little is left of it, or with time") {
  TwoViewStart<double, true> start({});
  REQUIRE(start.has_expired(0));
  for (int k = 0; k < TwoViewStartOptions{}.min_pairs; ++k) {
    start.add_pair(Vec<double, 3>::UnitZ(), Vec<double, 3>::UnitZ());
  }
  REQUIRE(!start.has_expired(1));
  REQUIRE(start.has_expired(TwoViewStartOptions{}.max_start_s + 0.1));
  start.clear_pairs();
  REQUIRE((start.pairs() == 0 && start.has_expired(0)));
}

TEST_CASE("two_view: more pairs than there is room for are left out") {
  using Start = TwoViewStart<float, true>;
  Start start({});
  for (std::size_t k = 0; k < Start::max_pairs + 100; ++k) {
    start.add_pair(Vec<float, 3>::UnitZ(), Vec<float, 3>::UnitZ());
  }
  REQUIRE(start.pairs() == int(Start::max_pairs));
}
