#include "plumbline/geometry/relative_pose.hpp"

#include <cmath>

#include "catch.hpp"
#include "geometry/two_view_scene.hpp"

using namespace plumbline;
using testing::TwoViewKind;
using testing::TwoViewScene;

namespace {

constexpr int seeds = 60;

struct Count {
  int valid = 0, good = 0, ambiguous = 0;
  std::array<int, 4> model{};
};

/// Of `seeds` scenes; an answer is good within 1.7 degrees of rotation and 11 of direction.
template <class S>
Count solve_all(TwoViewKind kind, double sigma_rad, double wrong, const RelativePoseOptions& options = {}) {
  Count out;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const TwoViewScene scene(kind, seed, sigma_rad, wrong);
    const auto pairs = scene.pairs_as<S>();
    const auto found = RelativePoseSolver<S, TwoViewScene::capacity>().solve(pairs, SO3<S>(), options);
    ++out.model[std::size_t(found.model)];
    out.ambiguous += found.failure == TwoViewFailure::ambiguous;
    CHECK(found.valid == (found.failure == TwoViewFailure::none));
    const SE3<S>& T = found.two_view.T_2_1;
    const auto good = [&](const SE3<S>& X) { return scene.rotation_error(X) < 0.03 && scene.direction_error(X) < 0.2; };
    if (found.failure == TwoViewFailure::ambiguous && kind == TwoViewKind::plane) {
      CHECK((good(T) || good(found.rival.T_2_1)));  // one of the two is right
    }
    if (!found.valid) continue;
    ++out.valid;
    out.good += good(T);
    int wrong_kept = 0, right_kept = 0, right = 0;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      right += !scene.wrong[i];
      (scene.wrong[i] ? wrong_kept : right_kept) += found.two_view.inlier[i];
    }
    CHECK(right_kept + wrong_kept == found.two_view.inliers);
    CHECK(right_kept > 0.8 * right);
    CHECK(wrong_kept < 15);
    CHECK(found.two_view.in_front > 0.95 * found.two_view.inliers);
    CHECK(found.two_view.T_2_1.p().norm() == Approx(1));
  }
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("relative_pose: general scenes, forward motion, half a radian, fisheye", "", float, double) {
  using S = TestType;
  const TwoViewKind kind =
      GENERATE(TwoViewKind::general, TwoViewKind::forward, TwoViewKind::turned, TwoViewKind::fisheye);
  const double wrong = GENERATE(0.0, 0.3);
  const Count count = solve_all<S>(kind, TwoViewScene::pixel, wrong);
  CAPTURE(int(kind), wrong, count.valid, count.good);
  CHECK(count.model[std::size_t(TwoViewModel::essential)] == seeds);
  CHECK(count.good >= 0.93 * seeds);
  CHECK(count.valid - count.good <= 1);
}

TEMPLATE_TEST_CASE("relative_pose: planes, most of them seen in two ways", "", float, double) {
  using S = TestType;
  const double wrong = GENERATE(0.0, 0.3);
  const Count count = solve_all<S>(TwoViewKind::plane, TwoViewScene::pixel, wrong);
  CAPTURE(wrong, count.valid, count.good, count.ambiguous);
  CHECK(count.model[std::size_t(TwoViewModel::homography)] >= seeds - 1);
  CHECK(count.valid >= 0.25 * seeds);
  CHECK(count.valid - count.good <= 1);
  CHECK(count.valid + count.ambiguous >= seeds - 2);
}

TEMPLATE_TEST_CASE("relative_pose: a rotation is never taken for a motion", "", float, double) {
  using S = TestType;
  const double wrong = GENERATE(0.0, 0.3);
  const double pixels = GENERATE(0.25, 1.0, 1.8);  // the options have 0.9
  const Count count = solve_all<S>(TwoViewKind::rotation, pixels * TwoViewScene::pixel, wrong);
  CAPTURE(wrong, pixels, count.model);
  CHECK(count.valid == 0);
  CHECK(count.model[std::size_t(TwoViewModel::rotation)] >= seeds - 1);
}

TEMPLATE_TEST_CASE("relative_pose: the rotation of a rotation", "", float, double) {
  using S = TestType;
  const TwoViewScene scene(TwoViewKind::rotation, 4, TwoViewScene::pixel, 0.3);
  const auto found = RelativePoseSolver<S, TwoViewScene::capacity>().solve(scene.pairs_as<S>(), SO3<S>());
  CHECK(found.failure == TwoViewFailure::rotation_only);
  CHECK(scene.rotation_error(found.two_view.T_2_1) < 2e-3);
  CHECK(found.two_view.parallax < S(0.01));
  CHECK(found.noise_rad == Approx(TwoViewScene::pixel).epsilon(0.2));
}

TEST_CASE("relative_pose: far points leave little parallax") {
  TwoViewScene scene(TwoViewKind::general, 2, 0, 0);
  for (BearingPair<double>& pair : scene.pairs) {
    const double range = 10 + 10 * pair.f1.x();
    pair.f2 = (scene.T_2_1.rotation() * pair.f1 * range + 0.5 * scene.T_2_1.p()).normalized();
  }
  RelativePoseOptions options;
  options.sigma_rad = 1e-4;
  const auto found = RelativePoseSolver<double, 200>().solve(scene.pairs, SO3<double>(), options);
  CHECK(found.failure == TwoViewFailure::little_parallax);
  CHECK(scene.direction_error(found.two_view.T_2_1) < 0.05);  // but it was found
}

TEST_CASE("relative_pose: same input, same output; another seed, nearly the same") {
  const TwoViewScene scene(TwoViewKind::general, 9, TwoViewScene::pixel, 0.3);
  const RelativePoseSolver<float, 200> solver;
  const auto pairs = scene.pairs_as<float>();
  const auto a = solver.solve(pairs, SO3<float>()), b = solver.solve(pairs, SO3<float>());
  CHECK(a.two_view.T_2_1.p() == b.two_view.T_2_1.p());
  CHECK(a.two_view.T_2_1.rotation().quaternion().coeffs() == b.two_view.T_2_1.rotation().quaternion().coeffs());
  CHECK(a.two_view.inlier == b.two_view.inlier);
  RelativePoseOptions options;
  options.seed = 77;
  const auto c = solver.solve(pairs, scene.T_2_1.rotation().cast<float>(), options);
  CHECK((a.two_view.T_2_1.p() - c.two_view.T_2_1.p()).norm() < 0.05f);
}

TEMPLATE_TEST_CASE("relative_pose: few pairs, nothing but wrong pairs, NaN", "", float, double) {
  using S = TestType;
  const RelativePoseSolver<S, 200> solver;
  FixedVector<BearingPair<S>, 200> pairs;
  CHECK(solver.solve(pairs, SO3<S>()).failure == TwoViewFailure::few_pairs);

  const TwoViewScene random(TwoViewKind::general, 3, 0, 1);
  const auto none = solver.solve(random.pairs_as<S>(), SO3<S>());
  CHECK(!none.valid);
  CHECK(none.failure == TwoViewFailure::no_consensus);

  const TwoViewScene scene(TwoViewKind::general, 6, 1e-3, 0.1);
  pairs = scene.pairs_as<S>();
  pairs[3].f1.x() = pairs[5].f2.y() = S(NAN);
  pairs[8].f2.setConstant(S(INFINITY));
  const SO3<S> nan_guess = SO3<S>::exp(Vec<S, 3>::Constant(S(NAN)));
  for (const SO3<S>& guess : {SO3<S>(), nan_guess}) {
    const auto found = solver.solve(pairs, guess);
    REQUIRE(found.valid);
    CHECK(!found.two_view.inlier[3]);
    CHECK(!found.two_view.inlier[5]);
    CHECK(!found.two_view.inlier[8]);
    CHECK(scene.direction_error(found.two_view.T_2_1) < 0.1);
  }
  for (BearingPair<S>& pair : pairs) pair.f2.setConstant(S(NAN));
  CHECK(!solver.solve(pairs, SO3<S>()).valid);
  for (BearingPair<S>& pair : pairs) pair = {Vec<S, 3>::UnitZ(), Vec<S, 3>::UnitZ()};
  CHECK(!solver.solve(pairs, SO3<S>()).valid);
}
