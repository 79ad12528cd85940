#include "plumbline/geometry/five_point.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"
#include "plumbline/core/random_sample.hpp"
#include "plumbline/geometry/essential_matrix.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

TEMPLATE_TEST_CASE("five_point: the true matrix is among them", "", float, double) {
  using S = TestType;
  const TwoViewKind kind = GENERATE(TwoViewKind::general, TwoViewKind::plane, TwoViewKind::forward,
                                    TwoViewKind::fisheye, TwoViewKind::turned);
  constexpr bool single = std::is_same_v<S, float>;
  Random random(3);
  int found = 0, all = 0, solved = 0, exact = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const TwoViewScene scene(kind, seed, 0, 0);
    const auto pairs = scene.pairs_as<S>();
    std::array<BearingPair<S>, 5> five;
    const auto index = random_sample<5>(random, std::uint32_t(pairs.size()));
    for (std::size_t k = 0; k < 5; ++k) five[k] = pairs[index[k]];
    const Mat<double, 3, 3> truth = essential_matrix(scene.unit_T_2_1()) / std::sqrt(2.0);
    double closest = 10;
    for (const Mat<S, 3, 3>& E : five_point(five)) {
      const Mat<double, 3, 3> E_d = E.template cast<double>();
      closest = std::min({closest, (E_d - truth).norm(), (E_d + truth).norm()});
      for (const BearingPair<S>& pair : five) CHECK(std::abs(pair.f2.dot(E * pair.f1)) < S(single ? 1e-5 : 1e-10));
      const Mat<double, 3, 3> G = E_d * E_d.transpose();
      const double cubic = (G * E_d - 0.5 * G.trace() * E_d).norm() + std::abs(E_d.determinant());
      ++solved;
      exact += cubic < (single ? 1e-6 : 1e-9);
    }
    found += closest < (single ? 1e-2 : 1e-5);
    ++all;
  }
  CAPTURE(int(kind), found, all, exact, solved);
  // Roots lose digits where two of them nearly meet, as they do on planes: of 3000 samples in double precision the
  // truth is among the solutions of 0.96 on planes and of 0.993 or more elsewhere.
  CHECK(found >= (single || kind == TwoViewKind::plane ? 0.92 : 0.97) * all);
  CHECK(exact >= 0.85 * solved);
}

TEMPLATE_TEST_CASE("five_point: too little, NaN", "", float, double) {
  using S = TestType;
  const auto pairs = TwoViewScene(TwoViewKind::general, 1, 0, 0).pairs_as<S>();
  std::array<BearingPair<S>, 5> five{pairs[0], pairs[1], pairs[2], pairs[3], pairs[3]};
  CHECK(five_point(five).empty());
  five[4] = pairs[4];
  five[2].f1.setConstant(S(NAN));
  CHECK(five_point(five).empty());
}
