// The pose of a camera by features of an older one: exact, consistent whatever the baseline, by the best of what was
// measured.
#include "plumbline/map/place_refinement.hpp"

#include <cmath>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr double chi2 = 5.991;

/// Features of an older camera at 2 to 5 m, with noise in bearing and range, and a current camera that sees them.
template <class S>
struct Pair {
  testing::Gaussian noise;
  std::vector<PlaceFeature> old;
  std::vector<Vec<double, 3>> seen;  ///< without noise
  SE3<double> T_old_current;
  PlaceRefinement<S, 100> refinement;

  Pair(std::uint64_t seed, const Vec<double, 3>& baseline, double sigma_rad, double relative_sigma_range)
      : noise(seed), T_old_current(SO3<double>::exp({0.1, -0.2, 0.3}), baseline) {
    for (int n = 0; n < 60; ++n) {
      const double u = 0.5 * std::sin(1.7 * n), v = 0.4 * std::cos(2.3 * n), range = 3.5 + 1.5 * std::sin(0.9 * n);
      const Vec<double, 3> bearing = normalized(Vec<double, 3>(u, v, 1));
      PlaceFeature feature;
      feature.bearing = cast_to<float>(normalized(Vec<double, 3>(bearing + sigma_rad * noise.vector<3>())));
      feature.sigma_rad = float(sigma_rad);
      feature.sigma_range = float(relative_sigma_range * range);
      feature.range = float(range * (1 + relative_sigma_range * noise()));
      old.push_back(feature);
      seen.push_back(normalized(Vec<double, 3>(T_old_current.inverse() * Vec<double, 3>(range * bearing))));
    }
  }
  Vec<S, 3> observed(std::size_t n, double sigma_rad) {
    return cast_to<S>(normalized(Vec<double, 3>(seen[n] + sigma_rad * noise.vector<3>())));
  }
  Vec<double, 6> error(const SE3<S>& T) const { return minus(T.template cast<double>(), T_old_current); }
  /// A pose that is off by some of these sigmas, as MSAC finds it.
  SE3<S> guess(double sigma_rad = 1e-3) const {
    Vec<double, 6> off;
    off << 1, -1, 0.5, 2, -3, 2;
    return plus(T_old_current, Vec<double, 6>(2 * sigma_rad * off)).template cast<S>();
  }
};

}  // namespace

TEMPLATE_TEST_CASE("place_refinement: without noise it is exact", "", float, double) {
  using S = TestType;
  Pair<S> pair(1, {0.3, 0.2, -0.1}, 0, 0);
  for (std::size_t n = 0; n < pair.old.size(); ++n)
    REQUIRE(pair.refinement.add(pair.old[n], pair.observed(n, 0), S(1e-3)));
  SE3<S> T = pair.guess();
  REQUIRE(pair.refinement.solve(T, S(chi2)));
  CHECK(pair.error(T).norm() < 1e-5);
  CHECK(pair.refinement.inliers() == 60);
}

TEST_CASE("place_refinement: its covariance is that of its errors, with bearings or ranges as the larger error") {
  struct Case {
    double baseline, sigma_rad, relative_sigma_range;
  };
  for (const Case& c : {Case{0.1, 0.002, 0.01}, Case{0.8, 0.0003, 0.03}}) {
    double nees = 0;
    constexpr int runs = 80;
    for (std::uint64_t seed = 1; seed <= runs; ++seed) {
      Pair<double> pair(seed, {c.baseline, -c.baseline / 2, 0.05}, c.sigma_rad, c.relative_sigma_range);
      for (std::size_t n = 0; n < pair.old.size(); ++n)
        (void)pair.refinement.add(pair.old[n], pair.observed(n, c.sigma_rad), c.sigma_rad);
      SE3<double> T = pair.guess(c.sigma_rad);
      REQUIRE(pair.refinement.solve(T, chi2));
      const auto L = square_root_information(pair.refinement.covariance());
      REQUIRE(L);
      nees += squared_norm(Vec<double, 6>(times(*L, pair.error(T)))) / runs;
    }
    CAPTURE(c.baseline, nees);
    CHECK(nees > 3);  // 6 expected
    CHECK(nees < 9);
  }
}

TEST_CASE("place_refinement: errors of ranges do not hide what is measured across the epipolar lines") {
  // The same features with ranges of 10 %: what they move is along one direction alone.
  Pair<double> pair(3, {0.6, 0, 0}, 1e-4, 0.1);
  for (std::size_t n = 0; n < pair.old.size(); ++n)
    (void)pair.refinement.add(pair.old[n], pair.observed(n, 1e-4), 1e-4);
  SE3<double> T = pair.guess(1e-4);
  REQUIRE(pair.refinement.solve(T, chi2));
  CHECK(pair.refinement.inliers() >= 48);
  CHECK(pair.error(T).head<3>().norm() < 1e-3);
}

TEST_CASE("place_refinement: what was aligned takes the place of its match, with the noise that it turns out to have") {
  Pair<double> matched(5, {0.2, 0.1, 0}, 0, 0), aligned(5, {0.2, 0.1, 0}, 0, 0);
  constexpr double of_match = 0.002, of_patch = 0.0005;
  for (std::size_t n = 0; n < matched.old.size(); ++n) {
    const Vec<double, 3> bearing = matched.observed(n, of_match);
    (void)matched.refinement.add(matched.old[n], bearing, of_match);
    (void)aligned.refinement.add(aligned.old[n], bearing, of_match);
  }
  SE3<double> T = matched.guess(), T_aligned = T;
  REQUIRE(matched.refinement.solve(T, chi2));
  for (std::size_t n = 0; n < 40; ++n)  // said to be five times as good as they are
    REQUIRE(aligned.refinement.add_aligned(aligned.old[n], aligned.observed(n, of_patch), of_patch / 5));
  CHECK(aligned.refinement.size() == matched.refinement.size());
  for (int pass = 0; pass < 3; ++pass) {
    aligned.refinement.scale_aligned(T_aligned);
    REQUIRE(aligned.refinement.solve(T_aligned, chi2));
  }
  CHECK(aligned.error(T_aligned).norm() < 0.6 * matched.error(T).norm());
  CHECK(aligned.refinement.covariance().trace() < 0.3 * matched.refinement.covariance().trace());
  for (std::size_t m = 0; m < 40; ++m) {
    CHECK(aligned.refinement[m].sigma_rad > 0.6 * of_patch);
    CHECK(aligned.refinement[m].sigma_rad < 1.6 * of_patch);
  }
}

TEST_CASE("place_refinement: what does not agree is no inlier, and too little or NaN has no solution") {
  Pair<double> pair(7, {0.2, 0.1, 0}, 0, 0);
  for (std::size_t n = 0; n < pair.old.size(); ++n) {
    Vec<double, 3> bearing = pair.observed(n, 0);
    if (n % 5 == 0) bearing = normalized(Vec<double, 3>(bearing + Vec<double, 3>(0.1, 0, 0)));
    (void)pair.refinement.add(pair.old[n], bearing, 1e-3);
  }
  SE3<double> T = pair.guess();
  REQUIRE(pair.refinement.solve(T, chi2));
  CHECK(pair.refinement.inliers() == 48);
  CHECK(pair.error(T).norm() < 1e-3);
  pair.refinement.keep_inliers();
  CHECK(pair.refinement.size() == 48);

  Pair<double> few(8, {0.2, 0.1, 0}, 0, 0), broken(8, {0.2, 0.1, 0}, 0, 0);
  for (std::size_t n = 0; n < 5; ++n) (void)few.refinement.add(few.old[n], few.observed(n, 0), 1e-3);
  SE3<double> unchanged = few.guess();
  CHECK_FALSE(few.refinement.solve(unchanged, chi2));
  for (std::size_t n = 0; n < broken.old.size(); ++n) {
    if (n > 3) broken.old[n].range = std::nanf("");
    (void)broken.refinement.add(broken.old[n], broken.observed(n, 0), 1e-3);
  }
  CHECK_FALSE(broken.refinement.solve(unchanged, chi2));
}
