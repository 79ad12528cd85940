#include "plumbline/initialization/two_view.hpp"

#include <cstddef>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

namespace {

/// An initializer, and the given rotation between the views.
template <class ScalarT, template <class, std::size_t> class Solver, bool knows_rotation>
struct Case {
  using S = ScalarT;
  using Start = TwoViewInitializer<S, Solver>;
  static SO3<S> guess(const TwoViewScene& scene) {
    return knows_rotation ? scene.T_2_1.rotation().template cast<S>() : SO3<S>();
  }
  static Start with_pairs(const TwoViewScene& scene, const typename Start::Options& options = {}) {
    Start start(options);
    for (const BearingPair<double>& pair : scene.pairs) {
      start.add_pair(pair.f1.template cast<S>(), pair.f2.template cast<S>());
    }
    return start;
  }
};
using GuidedFloat = Case<float, GuidedTwoView, true>;
using Guided = Case<double, GuidedTwoView, true>;
using UnguidedFloat = Case<float, UnguidedTwoView, false>;
using Unguided = Case<double, UnguidedTwoView, false>;

}  // namespace

TEMPLATE_TEST_CASE("two_view: a second view from aside is found, a fifth of the unit away", "", GuidedFloat, Guided,
                   UnguidedFloat, Unguided) {
  using S = typename TestType::S;
  typename TestType::Start::Options options;
  options.min_parallax_rad = 0.02;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoViewScene scene(TwoViewKind::general, seed, TwoViewScene::pixel / 2, 0.1);
    auto start = TestType::with_pairs(scene, options);
    REQUIRE(start.pairs() == int(scene.pairs.size()));
    InitReport report;
    if (!start.solve(TestType::guess(scene), report)) continue;  // of little parallax
    ++found;
    CAPTURE(seed, report.parallax_rad, report.inliers);
    REQUIRE(report.parallax_rad > options.min_parallax_rad);
    REQUIRE((report.inliers > 0.8 && report.inliers <= 1));
    const SE3<S> T_2_1 = start.T_1_2().inverse();
    REQUIRE(double(T_2_1.p().norm()) == Approx(0.2));
    REQUIRE(double(start.T_1_2(S(0.7)).p().norm()) == Approx(0.7));  // where it is known
    REQUIRE(scene.rotation_error(T_2_1) < 0.01);
    REQUIRE(scene.direction_error(T_2_1) < 0.1);
  }
  REQUIRE(found >= 8);
}

TEMPLATE_TEST_CASE("two_view: a camera that only turns waits for parallax", "", Guided, Unguided) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoViewScene scene(TwoViewKind::rotation, seed, TwoViewScene::pixel, 0.1);
    auto start = TestType::with_pairs(scene);
    InitReport report{.stage = InitStage::little_parallax};
    REQUIRE(!start.solve(TestType::guess(scene), report));
    REQUIRE(report.stage == InitStage::little_parallax);
    REQUIRE(report.parallax_rad < TwoViewInitializerOptions{}.min_parallax_rad);
  }
}

TEMPLATE_TEST_CASE("two_view: a view with half of the pairs wrong is no second view", "", Guided, Unguided) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const TwoViewScene scene(TwoViewKind::general, seed, TwoViewScene::pixel, 0.5);
    auto start = TestType::with_pairs(scene);
    InitReport report{.stage = InitStage::little_parallax};
    REQUIRE(!start.solve(TestType::guess(scene), report));
    REQUIRE(report.inliers < TwoViewInitializerOptions{}.min_inliers);
  }
}

TEST_CASE("two_view: a first view expires when little is left of it, or with time") {
  const Guided::Start::Options options;
  Guided::Start start(options);
  REQUIRE(start.has_expired(0));
  for (int k = 0; k < options.min_pairs; ++k) {
    start.add_pair(Vec<double, 3>::UnitZ(), Vec<double, 3>::UnitZ());
  }
  REQUIRE(!start.has_expired(1));
  REQUIRE(start.has_expired(TwoViewInitializerOptions{}.max_wait_s + 0.1));
  start.clear_pairs();
  REQUIRE((start.pairs() == 0 && start.has_expired(0)));
}

TEST_CASE("two_view: more pairs than there is room for are left out") {
  UnguidedFloat::Start start({});
  constexpr std::size_t max_pairs = UnguidedFloat::Start::max_pairs;
  for (std::size_t k = 0; k < max_pairs + 100; ++k) start.add_pair(Vec<float, 3>::UnitZ(), Vec<float, 3>::UnitZ());
  REQUIRE(start.pairs() == int(max_pairs));
}
