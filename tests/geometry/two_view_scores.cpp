#include "plumbline/geometry/two_view_scores.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

TEMPLATE_TEST_CASE("two_view_scores: the most there is without noise, little for a wrong model", "", float, double) {
  using S = TestType;
  const TwoViewScene general(TwoViewKind::general, 1, 0, 0), plane(TwoViewKind::plane, 2, 0, 0);
  const auto general_pairs = general.pairs_as<S>(), plane_pairs = plane.pairs_as<S>();
  const TwoViewScores<S> of_general(general_pairs, S(2e-3)), of_plane(plane_pairs, S(2e-3));
  const S all = S(TwoViewScene::capacity) * 2 * TwoViewScores<S>::most;
  const Mat<double, 3, 3> H_d = plane.T_2_1.R() + plane.T_2_1.p() * plane.n_1.transpose();
  const Mat<S, 3, 3> E = essential_matrix(SE3<S>(general.unit_T_2_1().cast<S>())), H = H_d.template cast<S>();
  CHECK(of_general.essential(E) == Approx(all).epsilon(1e-4));
  CHECK(of_plane.homography(H) == Approx(all).epsilon(1e-4));
  CHECK(of_general.homography(H) < all / 4);
  CHECK(of_plane.essential(E) < all / 4);
  CHECK(of_general.homography(general.T_2_1.rotation().template cast<S>().matrix()) < all / 4);
  CHECK(of_plane.essential(E, all) <= of_plane.essential(E));  // ended early
}

TEMPLATE_TEST_CASE("two_view_scores: only the true one of four motions has the points in front", "", float, double) {
  using S = TestType;
  const TwoViewKind kind = GENERATE(TwoViewKind::general, TwoViewKind::forward, TwoViewKind::fisheye);
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const TwoViewScene scene(kind, seed, 1e-3, 0);
    const auto pairs = scene.pairs_as<S>();
    const TwoViewScores<S> scores(pairs, S(1e-3));
    const SE3<S> T = scene.unit_T_2_1().cast<S>();
    const SupportedMotion<S> truth = scores.supported(T);
    CHECK(truth.pairs > 180);
    CHECK(truth.support == Approx(scores.essential(essential_matrix(T))).epsilon(0.02));
    for (const SE3<S>& other : motions_of_essential(essential_matrix(T))) {
      const bool same = scene.rotation_error(other) < 0.1 && scene.direction_error(other) < 0.1;
      CHECK(scores.supported(other).support < (same ? S(1.01) : S(0.5)) * truth.support);
    }
  }
}

TEMPLATE_TEST_CASE("two_view_scores: the noise is estimated though another was stated", "", float, double) {
  using S = TestType;
  const double said = GENERATE(1e-3, 2e-3);
  double mean = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const TwoViewScene scene(TwoViewKind::general, seed, 2e-3, 0.3);
    const auto pairs = scene.pairs_as<S>();
    const Mat<S, 3, 3> E = essential_matrix(SE3<S>(scene.unit_T_2_1().cast<S>()));
    mean += double(TwoViewScores<S>(pairs, S(said)).noise(E, S(3 * said))) / 20;
  }
  CHECK(mean == Approx(2e-3).epsilon(0.1));
}
