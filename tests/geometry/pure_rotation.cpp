#include "plumbline/geometry/pure_rotation.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

TEMPLATE_TEST_CASE("pure_rotation: from far away without wrong pairs, from near with them", "", float, double) {
  using S = TestType;
  const double wrong = GENERATE(0.0, 0.3);
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const TwoViewScene scene(TwoViewKind::rotation, seed, 1e-3, wrong);
    auto pairs = scene.pairs_as<S>();
    pairs[3].f1.setConstant(S(NAN));  // without consequence
    const std::span<const BearingPair<S>> all(pairs.data(), pairs.size());
    SO3<S> R = wrong > 0 ? SO3<S>(scene.T_2_1.rotation().template cast<S>()) * SO3<S>::exp({S(0.02), S(0), S(0.02)})
                         : SO3<S>();
    for (const S scale : {wrong > 0 ? S(0.03) : S(1), S(0.01), S(0.003)}) REQUIRE(refine_rotation(all, scale, 6, R));
    CHECK(scene.rotation_error(SE3<S>(R, Vec<S, 3>::Zero())) < 1.5e-3);
  }
}

TEST_CASE("pure_rotation: too few or degenerate pairs") {
  SO3<double> R;
  std::array<BearingPair<double>, 4> pairs;
  for (BearingPair<double>& pair : pairs) pair.f1 = pair.f2 = Vec<double, 3>::Constant(NAN);
  CHECK(!refine_rotation<double>(pairs, 0.01, 3, R));
}
