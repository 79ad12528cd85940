#include "plumbline/geometry/homography.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

namespace {

template <class S>
Mat<S, 3, 3> true_homography(const TwoViewScene& scene) {
  const Mat<double, 3, 3> H = scene.T_2_1.R() + scene.T_2_1.p() * scene.n_1.transpose();
  return (H / H.norm()).template cast<S>();
}

}  // namespace

TEMPLATE_TEST_CASE("homography: from four pairs", "", float, double) {
  using S = TestType;
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const TwoViewScene scene(TwoViewKind::plane, seed, 0, 0);
    const auto pairs = scene.pairs_as<S>();
    Mat<S, 3, 3> H;
    REQUIRE(homography_of_four<S>({pairs[0], pairs[1], pairs[2], pairs[3]}, H));
    found += (H - true_homography<S>(scene)).norm() < S(std::is_same_v<S, float> ? 1e-3 : 1e-8);
    for (std::size_t k = 0; k < 4; ++k) CHECK(transfer_error(H, pairs[k].f1, pairs[k].f2) < S(1e-8));
  }
  CHECK(found >= 180);  // others have three points nearly on a line
}

TEMPLATE_TEST_CASE("homography: four pairs that no plane shows, NaN", "", float, double) {
  using S = TestType;
  const auto pairs = TwoViewScene(TwoViewKind::plane, 1, 0, 0).pairs_as<S>();
  Mat<S, 3, 3> H;
  CHECK(!homography_of_four<S>({pairs[0], pairs[1], pairs[0], pairs[3]}, H));
  BearingPair<S> behind = pairs[3];
  behind.f2 = -behind.f2;
  CHECK(!homography_of_four<S>({pairs[0], pairs[1], pairs[2], behind}, H));
  behind.f2.setConstant(S(NAN));
  CHECK(!homography_of_four<S>({pairs[0], pairs[1], pairs[2], behind}, H));
}

TEMPLATE_TEST_CASE("homography: Jacobian of its error", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const TwoViewScene scene(TwoViewKind::plane, seed, 0.05, 0);  // errors far from zero
    const BearingPair<S> pair = scene.pairs_as<S>()[0];
    const Mat<S, 3, 3> H = true_homography<S>(scene);
    const HomographyError<S> error(H, pair);
    REQUIRE(error.valid);
    CHECK(S(error.r.norm()) == Approx(std::sqrt(transfer_error(H, pair.f1, pair.f2))).epsilon(1e-3));
    Vec<double, 9> h;
    for (int k = 0; k < 9; ++k) h[k] = double(H.data()[k]);
    const Vec<S, 3> b1_S = pair.f2.unitOrthogonal(), b2_S = pair.f2.cross(b1_S);
    const Vec<double, 3> b1 = b1_S.template cast<double>(), b2 = b2_S.template cast<double>();
    const auto f = [&](const Vec<double, 9>& x) -> Vec<double, 2> {
      Vec<double, 3> y = Vec<double, 3>::Zero();
      for (int k = 0; k < 9; ++k) y[k % 3] += x[k] * double(pair.f1[k / 3]);
      y.normalize();
      return {b1.dot(y), b2.dot(y)};
    };
    CHECK(testing::jacobian_error(error.J_r_H, f, h) < (std::is_same_v<S, float> ? 1e-5 : 1e-8));
  }
}

TEMPLATE_TEST_CASE("homography: refined over all pairs, a third of them wrong", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const TwoViewScene scene(TwoViewKind::plane, seed, TwoViewScene::pixel / 2, 0.3);
    const auto pairs = scene.pairs_as<S>();
    Mat<S, 3, 3> H = true_homography<S>(scene);
    for (int k = 0; k < 9; ++k) H.data()[k] += S(0.002 * std::sin(k + double(seed)));
    REQUIRE(refine_homography<S>(std::span<const BearingPair<S>>(pairs.data(), pairs.size()), S(0.004), 10, H));
    CHECK((H - true_homography<S>(scene)).norm() < S(0.006));
  }
}

TEMPLATE_TEST_CASE("homography: its motions, one of them the true one", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 3e-3 : 1e-6;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const TwoViewScene scene(TwoViewKind::plane, seed, 0, 0);
    const HomographyMotions<S> motions = motions_of_homography(Mat<S, 3, 3>(true_homography<S>(scene) * S(1.7)));
    REQUIRE(motions.valid);
    CHECK(motions.T_2_1.size() == 4);
    bool found = false;
    for (const SE3<S>& T : motions.T_2_1) {
      found = found || (scene.rotation_error(T) < tolerance && scene.direction_error(T) < tolerance);
    }
    CHECK(found);
    CHECK((motions.R_nearest.inverse() * scene.T_2_1.rotation().template cast<S>()).log().norm() < S(0.25));
  }
}

TEMPLATE_TEST_CASE("homography: a rotation has no motions, and is the nearest one", "", float, double) {
  using S = TestType;
  const TwoViewScene scene(TwoViewKind::rotation, 3, 0, 0);
  const HomographyMotions<S> motions = motions_of_homography(true_homography<S>(scene));
  REQUIRE(motions.valid);
  CHECK(motions.T_2_1.empty());
  CHECK(scene.rotation_error(SE3<S>(motions.R_nearest, Vec<S, 3>::Zero())) < 1e-5);
  CHECK(!motions_of_homography(Mat<S, 3, 3>(Mat<S, 3, 3>::Zero())).valid);
  CHECK(!motions_of_homography(Mat<S, 3, 3>(Mat<S, 3, 3>::Constant(S(NAN)))).valid);
}
