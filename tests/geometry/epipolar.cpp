#include "plumbline/geometry/epipolar.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

TEMPLATE_TEST_CASE("epipolar: no error without noise, and the angle to the plane with it", "", float, double) {
  using S = TestType;
  const TwoViewScene scene(TwoViewKind::general, 1, 0, 0);
  const SE3<S> T = scene.unit_T_2_1().cast<S>();
  for (BearingPair<S> pair : scene.pairs_as<S>()) {
    CHECK(std::abs(epipolar_error(pair, T.rotation(), T.p())) < S(std::is_same_v<S, float> ? 1e-5 : 1e-13));
    const Vec<S, 3> normal = T.p().cross(T.rotation() * pair.f1).normalized();
    pair.f2 = std::cos(S(0.01)) * pair.f2 + std::sin(S(0.01)) * normal;
    CHECK(epipolar_error(pair, T.rotation(), T.p()) == Approx(std::sin(0.01)).epsilon(1e-3));
  }
}

TEMPLATE_TEST_CASE("epipolar: the translation of a known rotation, and both refined", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TwoViewScene scene(TwoViewKind::general, seed, TwoViewScene::pixel / 2, 0.3);
    auto pairs = scene.pairs_as<S>();
    pairs[7].f2.setConstant(S(NAN));  // without consequence
    const std::span<const BearingPair<S>> all(pairs.data(), pairs.size());
    SO3<S> R = scene.T_2_1.rotation().template cast<S>();
    Vec<S, 3> t;
    REQUIRE(consensus_translation(all, R, S(0.02), 60, seed, t));
    if (scene.direction_error(SE3<S>(R, t)) > 1.6) t = -t;
    CHECK(scene.direction_error(SE3<S>(R, t)) < 0.5);
    R = R * SO3<S>::exp({S(0.01), S(-0.01), S(0.01)});
    REQUIRE(refine_epipolar(all, S(0.016), 10, R, t));
    REQUIRE(refine_epipolar(all, S(0.004), 10, R, t));
    CHECK(scene.rotation_error(SE3<S>(R, t)) < 0.01);
    CHECK(scene.direction_error(SE3<S>(R, t)) < 0.12);
    CHECK(t.norm() == Approx(1));
  }
}
