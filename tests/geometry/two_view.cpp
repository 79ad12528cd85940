#include "plumbline/geometry/two_view.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

template <class S>
struct Scene {
  SE3<S> T_2_1{SO3<S>::exp({S(0.05), S(-0.12), S(0.08)}), Vec<S, 3>(S(0.2), S(-0.05), S(0.1))};
  FixedVector<BearingPair<S>, 200> pairs;

  /// Points 1 to 6 m away, bearings with noise, every third pair wrong when asked.
  Scene(double sigma_rad, bool with_outliers) {
    testing::Gaussian noise(5);
    Random random(7);
    const auto uniform = [&](double a, double b) { return S(a + (b - a) * random.uniform()); };
    const auto noisy = [&](Vec<S, 3> p) {
      return Vec<S, 3>((p.normalized() + S(sigma_rad) * noise.vector<3>().template cast<S>()).normalized());
    };
    for (int i = 0; i < 150; ++i) {
      const Vec<S, 3> p{uniform(-1.5, 1.5), uniform(-1, 1), uniform(1, 6)};
      Vec<S, 3> seen = T_2_1 * p;
      if (with_outliers && i % 3 == 0) seen = Vec<S, 3>{uniform(-1, 1), uniform(-1, 1), S(2)};
      pairs.push_back({noisy(p), noisy(seen)});
    }
  }
};

}  // namespace

TEMPLATE_TEST_CASE("two_view: the pose from a rotation that is wrong by three degrees", "", float, double) {
  using S = TestType;
  const double sigma = GENERATE(0.0, 1e-3);
  const Scene<S> scene(sigma, false);
  TwoViewSolver<S, 200> solver;
  const SO3<S> guess = scene.T_2_1.rotation() * SO3<S>::exp({S(0.03), S(0.04), S(-0.02)});
  const auto found = solver.solve(scene.pairs, guess, {});
  REQUIRE(found.valid);
  const S rotation_error = (found.T_2_1.rotation().inverse() * scene.T_2_1.rotation()).log().norm();
  const S direction_error = (found.T_2_1.p() - scene.T_2_1.p().normalized()).norm();
  CAPTURE(sigma, rotation_error, direction_error);
  REQUIRE(rotation_error < S(sigma > 0 ? 6e-3 : 1e-3));
  REQUIRE(direction_error < S(sigma > 0 ? 0.06 : 0.01));
  REQUIRE(found.in_front > 140);
  REQUIRE(found.parallax > S(0.03));
}

TEMPLATE_TEST_CASE("two_view: inliers and outliers are distinguished", "", float, double) {
  using S = TestType;
  const Scene<S> scene(5e-4, true);
  TwoViewSolver<S, 200> solver;
  const auto found = solver.solve(scene.pairs, scene.T_2_1.rotation(), {});
  REQUIRE(found.valid);
  REQUIRE((found.T_2_1.p() - scene.T_2_1.p().normalized()).norm() < S(0.1));
  int right_kept = 0, wrong_kept = 0;
  for (std::size_t i = 0; i < scene.pairs.size(); ++i) (i % 3 == 0 ? wrong_kept : right_kept) += found.inlier[i];
  REQUIRE(right_kept > 90);
  REQUIRE(wrong_kept < 15);
}

TEST_CASE("two_view: too few or degenerate pairs") {
  TwoViewSolver<double, 200> solver;
  FixedVector<BearingPair<double>, 200> few;
  REQUIRE(!solver.solve(few, SO3<double>(), {}).valid);
  Scene<double> scene(0, false);
  for (BearingPair<double>& pair : scene.pairs) pair.f2.setConstant(std::nan(""));
  const auto found = solver.solve(scene.pairs, SO3<double>(), {});
  REQUIRE((!found.valid || found.inliers == 0));
}

TEST_CASE("two_view: pure rotation shows as no parallax") {
  Scene<double> scene(2e-4, false);
  const SO3<double> R = scene.T_2_1.rotation();
  for (BearingPair<double>& pair : scene.pairs) pair.f2 = R * pair.f1;
  TwoViewSolver<double, 200> solver;
  const auto found = solver.solve(scene.pairs, R, {});
  REQUIRE((!found.valid || found.parallax < 5e-3));
}
