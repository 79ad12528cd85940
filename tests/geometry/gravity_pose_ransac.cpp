#include "plumbline/geometry/gravity_pose_ransac.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t capacity = 120;
constexpr double sigma = 2e-3;

double symmetric(Random& random) { return 2 * random.uniform() - 1; }

template <class S>
struct Scene {
  SE3<double> T_cam_world;
  Vec<S, 3> up_cam;
  FixedVector<PoseCorrespondence<S>, capacity> correspondences;
  std::array<bool, capacity> outlier{};
};

template <class S>
Scene<S> make_scene(std::uint64_t seed, double outlier_ratio, double noise = sigma, double tilt = 0,
                    std::size_t points = capacity) {
  Random random(seed);
  testing::Gaussian normal(seed);
  Scene<S> scene;
  Vec<double, 6> xi;
  for (int i = 0; i < 6; ++i) xi[i] = 1.5 * symmetric(random);
  scene.T_cam_world = SE3<double>::exp(xi);
  const Vec<double, 3> up = scene.T_cam_world.rotation() * Vec<double, 3>(0, 0, 1);
  const Vec<double, 3> axis = tilt * unit_orthogonal(up);
  scene.up_cam = Vec<double, 3>(SO3<double>::exp(axis) * up).cast<S>();
  for (std::size_t i = 0; i < points; ++i) {
    const double z = 1 + 6 * random.uniform();
    const Vec<double, 3> p_cam{0.8 * z * symmetric(random), 0.6 * z * symmetric(random), z};
    Vec<double, 3> bearing = p_cam.normalized();
    scene.outlier[i] = random.uniform() < outlier_ratio;
    if (scene.outlier[i]) {
      bearing = Vec<double, 3>{0.8 * symmetric(random), 0.6 * symmetric(random), 1}.normalized();
    } else {
      bearing = (bearing + noise * normal.vector<3>()).normalized();
    }
    const Vec<double, 3> p_world = scene.T_cam_world.inverse() * p_cam;
    scene.correspondences.push_back({bearing.cast<S>(), p_world.cast<S>(), S(sigma)});
  }
  return scene;
}

template <class S>
double error(const Scene<S>& scene, const SE3<S>& T) {
  return minus(T.template cast<double>(), scene.T_cam_world).norm();
}

}  // namespace

TEMPLATE_TEST_CASE("gravity_pose_ransac: half of the points wrong, prior useless", "", float, double) {
  using S = TestType;
  for (const double tilt : {0.0, 0.01}) {
    for (std::uint64_t seed = 1; seed <= 50; ++seed) {
      const Scene<S> scene = make_scene<S>(seed, 0.5, sigma, tilt);
      const auto result = ransac_gravity_pose(scene.correspondences, scene.up_cam, SE3<S>());
      CAPTURE(tilt, seed, result.inliers);
      REQUIRE(result.valid);
      REQUIRE(error(scene, result.T_cam_world) < 0.02);
      int wrong = 0, missed = 0;
      for (std::size_t i = 0; i < capacity; ++i) {
        wrong += scene.outlier[i] && result.inlier[i];
        missed += !scene.outlier[i] && !result.inlier[i];
      }
      CHECK(wrong <= 3);  // chance hits
      CHECK(missed <= 12);
    }
  }
}

TEST_CASE("gravity_pose_ransac: with few samples and many outliers, more poses than with three points") {
  const PoseRansacOptions options{.max_iterations = 20};
  int with_gravity = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    const Scene<double> scene = make_scene<double>(seed, 0.8);
    const SE3<double> far(SO3<double>(), Vec<double, 3>(0, 0, 1e3));  // behind all points: no hypothesis
    with_gravity +=
        error(scene, ransac_gravity_pose(scene.correspondences, scene.up_cam, far, options).T_cam_world) < 0.05;
    without += error(scene, ransac_pose(scene.correspondences, far, options).T_cam_world) < 0.05;
  }
  CAPTURE(with_gravity, without);
  CHECK(with_gravity > without);
}

TEMPLATE_TEST_CASE("gravity_pose_ransac: three points and a gate", "", float, double) {
  using S = TestType;
  const PoseRansacOptions options{.min_inliers = 3};
  const Scene<S> few = make_scene<S>(8, 0, 0, 0, 3);
  const auto result = ransac_gravity_pose(few.correspondences, few.up_cam, SE3<S>(), options);
  REQUIRE(result.valid);
  REQUIRE(error(few, result.T_cam_world) < 0.02);

  const Scene<S> scene = make_scene<S>(6, 0.3);
  const auto upright = [&](const SE3<S>& T) {
    return (T.rotation() * Vec<S, 3>(0, 0, 1) - scene.up_cam).norm() < S(0.02);
  };
  REQUIRE(ransac_gravity_pose(scene.correspondences, scene.up_cam, SE3<S>(), {}, upright).valid);
  REQUIRE(!ransac_gravity_pose(scene.correspondences, scene.up_cam, SE3<S>(), {}, [](const SE3<S>&) {
             return false;
           }).valid);
}

TEMPLATE_TEST_CASE("gravity_pose_ransac: same input, same output; nothing to find, NaN", "", float, double) {
  using S = TestType;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  const Scene<S> scene = make_scene<S>(9, 0.4);
  const auto a = ransac_gravity_pose(scene.correspondences, scene.up_cam, SE3<S>()),
             b = ransac_gravity_pose(scene.correspondences, scene.up_cam, SE3<S>());
  CHECK(a.inlier == b.inlier);
  CHECK(a.T_cam_world.p() == b.T_cam_world.p());

  FixedVector<PoseCorrespondence<S>, capacity> few;
  CHECK(!ransac_gravity_pose(few, scene.up_cam, SE3<S>()).valid);
  for (std::size_t i = 0; i < 2; ++i) few.push_back(scene.correspondences[i]);
  CHECK(!ransac_gravity_pose(few, scene.up_cam, SE3<S>()).valid);
  const Scene<S> hopeless = make_scene<S>(3, 1.0);
  CHECK(ransac_gravity_pose(hopeless.correspondences, hopeless.up_cam, SE3<S>()).inliers < 12);

  Scene<S> poisoned = make_scene<S>(6, 0.1);
  poisoned.correspondences[3].p_world.x() = nan;
  poisoned.correspondences[5].bearing.y() = nan;
  poisoned.correspondences[7].sigma_rad = nan;
  const SE3<S> nan_prior(SO3<S>(), Vec<S, 3>(nan, nan, nan));
  const auto result = ransac_gravity_pose(poisoned.correspondences, poisoned.up_cam, nan_prior);
  REQUIRE(result.valid);
  CHECK((!result.inlier[3] && !result.inlier[5] && !result.inlier[7]));
  CHECK(error(poisoned, result.T_cam_world) < 0.01);
  CHECK(!ransac_gravity_pose(poisoned.correspondences, Vec<S, 3>(nan, nan, nan), nan_prior).valid);
}
