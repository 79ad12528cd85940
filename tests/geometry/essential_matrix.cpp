#include "plumbline/geometry/essential_matrix.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

TEMPLATE_TEST_CASE("essential_matrix: its motions, one of them the true one, whatever its sign and length", "", float,
                   double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-9;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const TwoViewScene scene(TwoViewKind::turned, seed, 0, 0);
    const Mat<S, 3, 3> E = essential_matrix(SE3<S>(scene.unit_T_2_1().cast<S>()));
    const std::array<SE3<S>, 4> motions = motions_of_essential(Mat<S, 3, 3>(E * S(seed % 2 ? 2.5 : -0.3)));
    int found = 0;
    for (const SE3<S>& T : motions) {
      found += scene.rotation_error(T) < tolerance && scene.direction_error(T) < tolerance;
      const Mat<S, 3, 3> again = essential_matrix(T);
      CHECK(std::min((again - E).norm(), (again + E).norm()) < tolerance);
      CHECK(T.p().norm() == Approx(1));
    }
    CHECK(found == 1);
    const SO3<S> half_turn = motions[0].rotation() * motions[2].rotation().inverse();
    CHECK(half_turn.log().norm() == Approx(3.14159265).epsilon(1e-3));
  }
}

TEMPLATE_TEST_CASE("essential_matrix: its error has the variance of the noise of either bearing", "", float, double) {
  using S = TestType;
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const TwoViewScene scene(TwoViewKind::fisheye, seed, 1e-3, 0);
    const Mat<S, 3, 3> E = essential_matrix(SE3<S>(scene.unit_T_2_1().cast<S>()));
    for (const BearingPair<S>& pair : scene.pairs_as<S>()) sum += double(sampson_error(E, pair)), ++count;
  }
  CHECK(sum / count == Approx(1e-6).epsilon(0.05));
}
