#include "plumbline/testing/simulated_points.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

using Sensors = Rig<Rgbd<Pinhole<double>>>;
using Kind = PointKind<Sensors>;
using Store = LandmarkStore<Kind, 400, 3>;

const SE3<double> T_first(SO3<double>(), Vec<double, 3>(0, 0, -3));
const SE3<double> T_second(SO3<double>::exp({0.02, 0.1, 0}), Vec<double, 3>(0.2, 0, -3));

testing::SimulatedPoints cloud(int count) {
  testing::SimulatedPoints points;
  points.scatter(count, {1.5, 1, 1.5}, 1);
  return points;
}

}  // namespace

TEST_CASE("simulated_points: without noise landmarks and observations are exact") {
  testing::SimulatedPoints points = cloud(200);
  points.noise_scale = 0;
  Store store{{}};
  testing::Gaussian noise(1);
  points.observe(store, T_first, 0, noise);
  const std::size_t first = store.landmarks().size();
  points.observe(store, T_second, 1, noise);
  REQUIRE(first > 100);
  REQUIRE(store.landmarks().size() >= first);
  for (const auto& landmark : store.landmarks()) {
    const SE3<double>& T_anchor = landmark.anchor == 0 ? T_first : T_second;
    REQUIRE((T_anchor * Kind::middle(landmark.geometry) - points.p_world[landmark.id]).norm() < 1e-12);
    const testing::SeenPoint seen = points.see(T_second, landmark.id);
    REQUIRE(landmark.observations[1].valid == seen.valid);
    if (!seen.valid) continue;
    REQUIRE((landmark.observations[1].uv.cast<double>() - seen.uv).norm() < 1e-4);
    REQUIRE(landmark.observations[1].depth.get().value == Approx(1 / seen.p_cam.z()));
  }
}

TEST_CASE("simulated_points: noise has the sigmas of the observations, the first pixel has none") {
  const testing::SimulatedPoints points = cloud(400);
  Store store{{}};
  testing::Gaussian noise(2);
  points.observe(store, T_first, 0, noise);
  points.observe(store, T_second, 1, noise);
  double pixel = 0, depth = 0;
  int count = 0;
  for (const auto& landmark : store.landmarks()) {
    const auto& seen = landmark.observations[1];
    if (landmark.anchor != 0 || !seen.valid) continue;
    const testing::SeenPoint first = points.see(T_first, landmark.id), second = points.see(T_second, landmark.id);
    REQUIRE((landmark.observations[0].uv.cast<double>() - first.uv).norm() < 1e-4);
    pixel += (seen.L * (seen.uv - second.uv.cast<float>())).squaredNorm() / 2;
    depth += std::pow((seen.depth.get().value - 1 / second.p_cam.z()) / seen.depth.get().sigma, 2);
    ++count;
  }
  REQUIRE(count > 200);
  REQUIRE(pixel / count == Approx(1).margin(0.3));
  REQUIRE(depth / count == Approx(1).margin(0.4));
}

TEST_CASE("simulated_points: outliers by their share, and no more landmarks than there is room for") {
  testing::SimulatedPoints points = cloud(1000);
  points.outlier_share = 0.2;
  Store store{{}};
  testing::Gaussian noise(3);
  points.observe(store, T_first, 0, noise);
  REQUIRE(store.landmarks().full());
  points.observe(store, T_second, 1, noise);
  int seen = 0, outliers = 0;
  for (const auto& landmark : store.landmarks()) {
    if (!landmark.observations[1].valid) continue;
    ++seen;
    const Vec<double, 2> uv = points.see(T_second, landmark.id).uv;
    outliers += (landmark.observations[1].uv.cast<double>() - uv).norm() > 10;
  }
  REQUIRE(double(outliers) / seen == Approx(0.2).margin(0.06));
}
