#include "plumbline/geometry/pose_ransac.hpp"

#include <algorithm>
#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t capacity = 120;
constexpr double sigma = 2e-3;

double symmetric(Random& random) { return 2 * random.uniform() - 1; }
/// Sum of twelve uniform numbers: nearly normal, standard deviation 1.
double normal(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

template <class S>
struct Scene {
  SE3<double> T_cam_world;
  FixedVector<PoseCorrespondence<S>, capacity> correspondences;
  std::array<bool, capacity> outlier{};
};

template <class S>
Scene<S> make_scene(std::uint64_t seed, double outlier_ratio, double noise = sigma) {
  Random random(seed);
  Scene<S> scene;
  Vec<double, 6> xi;
  for (int i = 0; i < 6; ++i) xi[i] = 1.5 * symmetric(random);
  scene.T_cam_world = SE3<double>::exp(xi);
  for (std::size_t i = 0; i < capacity; ++i) {
    const double z = 1 + 6 * random.uniform();
    const Vec<double, 3> p_cam{0.8 * z * symmetric(random), 0.6 * z * symmetric(random), z};
    Vec<double, 3> bearing = p_cam.normalized();
    scene.outlier[i] = random.uniform() < outlier_ratio;
    if (scene.outlier[i]) {
      bearing = Vec<double, 3>{0.8 * symmetric(random), 0.6 * symmetric(random), 1}.normalized();
    } else {
      const Vec<double, 3> e{normal(random), normal(random), normal(random)};
      bearing = (bearing + noise * (e - bearing * bearing.dot(e))).normalized();
    }
    const Vec<double, 3> p_world = scene.T_cam_world.inverse() * p_cam;
    scene.correspondences.push_back({bearing.cast<S>(), p_world.cast<S>(), S(sigma)});
  }
  return scene;
}

}  // namespace

TEMPLATE_TEST_CASE("pose_ransac: Jacobian of the bearing error", "", float, double) {
  using S = TestType;
  Random random(5);
  for (int trial = 0; trial < 50; ++trial) {
    const Scene<S> scene = make_scene<S>(random.next(), 0);
    const PoseCorrespondence<S>& c = scene.correspondences[0];
    const SE3<S> T = scene.T_cam_world.template cast<S>();
    const BearingError<S> error(T, T.R(), c);
    const auto f = [&](const SE3<double>& X) -> Vec<double, 3> {
      return (X * Vec<double, 3>(c.p_world.template cast<double>())).normalized();
    };
    CHECK(testing::jacobian_error(error.J_r_T, f, T.template cast<double>()) <
          (std::is_same_v<S, float> ? 1e-5 : 1e-9));
  }
}

TEMPLATE_TEST_CASE("pose_ransac: half of the points wrong, prior useless, many seeds", "", float, double) {
  using S = TestType;
  int failures = 0;
  for (std::uint64_t seed = 1; seed <= 300; ++seed) {
    const Scene<S> scene = make_scene<S>(seed, 0.5);
    PoseRansacOptions options;
    options.seed = seed;
    const auto result = ransac_pose(scene.correspondences, SE3<S>(), options);
    const Vec<double, 6> error = minus(result.T_cam_world.template cast<double>(), scene.T_cam_world);
    const bool good =
        result.valid && error.template head<3>().norm() < 3 * sigma && error.template tail<3>().norm() < 0.02;
    failures += !good;
    if (!good) continue;
    int wrongly_kept = 0, wrongly_dropped = 0, kept = 0;
    for (std::size_t i = 0; i < capacity; ++i) {
      kept += result.inlier[i];
      wrongly_kept += result.inlier[i] && scene.outlier[i];
      wrongly_dropped += !result.inlier[i] && !scene.outlier[i];
    }
    CHECK(kept == result.inliers);
    CHECK(wrongly_kept <= 2);      // chance hits of the 2.4 sigma disc
    CHECK(wrongly_dropped <= 14);  // 5 % of about 60 are expected
  }
  CHECK(failures <= 3);  // 1 - confidence
}

TEMPLATE_TEST_CASE("pose_ransac: a good prior is refined without sampling", "", float, double) {
  using S = TestType;
  const Scene<S> scene = make_scene<S>(4, 0.05, 0.0);
  Vec<S, 6> d;
  d << S(1e-3), S(-1e-3), S(1e-3), S(1e-3), S(2e-3), S(-1e-3);
  PoseRansacOptions options;
  options.max_iterations = 0;
  const auto result =
      ransac_pose(scene.correspondences, plus(SE3<S>(scene.T_cam_world.template cast<S>()), d), options);
  REQUIRE(result.valid);
  CHECK(result.inliers > 100);
  CHECK(minus(result.T_cam_world.template cast<double>(), scene.T_cam_world).norm() <
        (std::is_same_v<S, float> ? 1e-5 : 1e-6));  // outliers keep a trace of weight
}

TEMPLATE_TEST_CASE("pose_ransac: a majority outside the gate of the prior is rejected in favor of a minority inside",
                   "", float, double) {
  using S = TestType;
  Scene<S> scene = make_scene<S>(6, 0, 0.2 * sigma);
  const SE3<S> T = scene.T_cam_world.template cast<S>();
  Vec<S, 6> d = Vec<S, 6>::Zero();
  d[3] = S(0.3);
  const SE3<S> T_of_most = plus(T, d);
  const std::size_t most = capacity * 2 / 3;
  for (std::size_t i = 0; i < most; ++i) {
    PoseCorrespondence<S>& c = scene.correspondences[i];
    c.bearing = normalized(Vec<S, 3>(T_of_most * c.p_world));
  }
  const auto near = [](const SE3<S>& a, const SE3<S>& b) { return minus(a, b).norm() < S(0.05); };
  const auto free = ransac_pose(scene.correspondences, T_of_most, {});
  REQUIRE(near(free.T_cam_world, T_of_most));
  CHECK(free.inliers >= int(most));

  const auto bound = ransac_pose(scene.correspondences, T_of_most, {}, [&](const SE3<S>& X) { return near(X, T); });
  REQUIRE(bound.valid);
  CHECK(near(bound.T_cam_world, T));
  const auto wrong = std::count(bound.inlier.begin(), bound.inlier.begin() + most, true);
  CHECK(wrong < 8);  // chance hits: distant points hardly distinguish the two poses
  CHECK(bound.inliers - wrong > 0.9 * (capacity - most));

  CHECK_FALSE(ransac_pose(scene.correspondences, T, {}, [](const SE3<S>&) { return false; }).valid);
}

TEST_CASE("pose_ransac: same input, same output") {
  const Scene<float> scene = make_scene<float>(9, 0.4);
  const auto a = ransac_pose(scene.correspondences, SE3<float>()), b = ransac_pose(scene.correspondences, SE3<float>());
  CHECK(a.inlier == b.inlier);
  CHECK(a.T_cam_world.p() == b.T_cam_world.p());
  CHECK(a.T_cam_world.rotation().quaternion().coeffs() == b.T_cam_world.rotation().quaternion().coeffs());
}

TEMPLATE_TEST_CASE("pose_ransac: nothing to find, too little, NaN", "", float, double) {
  using S = TestType;
  FixedVector<PoseCorrespondence<S>, capacity> few;
  CHECK(!ransac_pose(few, SE3<S>()).valid);
  const Scene<S> good = make_scene<S>(2, 0.0);
  for (std::size_t i = 0; i < 3; ++i) few.push_back(good.correspondences[i]);
  CHECK(!ransac_pose(few, SE3<S>()).valid);

  CHECK(ransac_pose(make_scene<S>(3, 1.0).correspondences, SE3<S>()).inliers < 12);

  Scene<S> poisoned = make_scene<S>(6, 0.1);
  poisoned.correspondences[3].p_world.x() = std::numeric_limits<S>::quiet_NaN();
  poisoned.correspondences[5].bearing.y() = std::numeric_limits<S>::quiet_NaN();
  poisoned.correspondences[7].sigma_rad = std::numeric_limits<S>::quiet_NaN();
  const SE3<S> nan_prior(SO3<S>(), Vec<S, 3>::Constant(std::numeric_limits<S>::quiet_NaN()));
  const auto result = ransac_pose(poisoned.correspondences, nan_prior);
  REQUIRE(result.valid);
  CHECK(!result.inlier[3]);
  CHECK(!result.inlier[5]);
  CHECK(!result.inlier[7]);
  CHECK(minus(result.T_cam_world.template cast<double>(), poisoned.T_cam_world).norm() < 0.01);

  for (auto& c : poisoned.correspondences) c.bearing.x() = std::numeric_limits<S>::quiet_NaN();
  const auto nothing = ransac_pose(poisoned.correspondences, nan_prior);
  CHECK(!nothing.valid);
  CHECK(nothing.inliers == 0);
}
