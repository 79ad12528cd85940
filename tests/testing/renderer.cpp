#include "plumbline/testing/renderer.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"
#include "plumbline/camera/equidistant.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;
using namespace plumbline::testing;

namespace {

constexpr int width = 161, height = 120;  // not whole tiles
constexpr double coarse = 4;              // texels: the geometry is what is tested

/// Every pixel against a ray through the scene; returns the share of pixels that differ (edges, where rounding
/// decides).
template <class Camera>
double mismatch(const Camera& camera, Renderer& renderer, const SE3<double>& T_world_cam) {
  Image<float> gray(width, height), depth(width, height);
  renderer.render(T_world_cam, gray.view(), depth.view());
  int wrong = 0;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Vec<double, 3> ray = camera.unproject({double(x), double(y)}).bearing;
      const double z = renderer.scene().intersect(T_world_cam.p(), T_world_cam.rotation() * ray) * ray.z();
      if (!(std::abs(z - double(depth.view()(x, y))) < 1e-4 * z)) ++wrong;
    }
  }
  return wrong / double(width * height);
}

template <class Camera>
void check(const Camera& camera) {
  const Scene scene = *make_scene("corridor", 2);
  Renderer renderer(scene, camera, width, height, coarse);
  const Trajectory trajectory = *Trajectory::for_scene("corridor", 2);
  for (const double t : {0.0, 4.0, 9.0}) {
    REQUIRE(mismatch(camera, renderer, trajectory.at(t).T_world_body * simulated_T_body_camera()) < 0.002);
  }
}

}  // namespace

TEST_CASE("renderer: depth equals a ray through every rectangle, for every kind of camera") {
  check(Pinhole<double>{135, 134, 79.5, 60.2});
  check(Pinhole<double, RadTan>{115, 114, 79.5, 60.2, {-0.28, 0.07, 2e-4, 1e-4}});
  check(Equidistant<double>(70, 70, 79.5, 60.2, -0.01, 0.02, -0.01, 0.002));
}

TEST_CASE("renderer: depth of a single wall is the plane's") {
  Scene scene;
  scene.add_rectangle({}, {0, 0, 2}, -Vec<double, 3>::UnitZ(), 20, 20, {Pattern::plain, 0.5f, 0, 1});
  const Pinhole<double> camera{135, 135, 80, 60};
  Renderer renderer(scene, camera, width, height, 40);
  Image<float> gray(width, height), depth(width, height);
  renderer.render({SO3<double>::exp({0.3, 0, 0}), {0, 0, 0}}, gray.view(), depth.view());
  for (int y = 0; y < height; y += 7) {
    for (int x = 0; x < width; x += 7) {  // z of R^T applied to the ray's point on the plane z = 2
      const Vec<double, 3> m((x - 80) / 135.0, (y - 60) / 135.0, 1);
      const double z = 2 / (SO3<double>::exp({0.3, 0, 0}) * m).z();
      REQUIRE(double(depth.view()(x, y)) == Approx(z).epsilon(1e-5));
    }
  }
  renderer.render({SO3<double>(), {0, 0, 3}}, gray.view(), depth.view());  // behind the wall: it has one side
  REQUIRE(*std::max_element(depth.pixels().begin(), depth.pixels().end()) == 0);
}

TEST_CASE("renderer: an edge is anti-aliased and lies where it projects to") {
  const Pinhole<double> camera{400, 400, 80, 60};
  for (double shift = 0; shift < 1; shift += 0.13) {
    Scene scene;
    const double edge_px = 70.3 + shift, edge = (edge_px - 80) / 400 * 2;  // on the wall at z = 2
    scene.add_rectangle({}, {edge - 2, 0, 2}, -Vec<double, 3>::UnitZ(), 4, 4, {Pattern::plain, 0.5f, 0, 1});
    Renderer renderer(scene, camera, width, height, 40);
    Image<float> gray(width, height), depth(width, height);
    renderer.render({}, gray.view(), depth.view());
    const float* row = gray.view().row(60);
    double covered = 0;  // pixel k covers [k - 0.5, k + 0.5]: the sum of the coverages is the edge's place
    for (int x = 40; x < 100; ++x) covered += double(row[x] / row[40]);
    REQUIRE(39.5 + covered == Approx(edge_px).margin(0.04));       // 16 rays: steps of 1/16 px ...
    REQUIRE(gray.view()(int(std::lround(edge_px)) + 2, 60) == 0);  // ... and no more than one pixel wide
  }
}

TEST_CASE("renderer: under a rolling shutter every row is what its own pose sees") {
  const Scene scene = *make_scene("corridor", 2);
  const Pinhole<double> camera{135, 134, 79.5, 60.2};
  Renderer renderer(scene, camera, width, height, coarse);
  const Trajectory trajectory = *Trajectory::for_scene("walk", 2);
  constexpr double row_s = 0.03 / height;
  const auto T_world_cam = [&](double row) {
    return trajectory.at(6 + (row - 0.5 * (height - 1)) * row_s).T_world_body * simulated_T_body_camera();
  };
  Image<float> gray(width, height), depth(width, height);
  renderer.render_rolling(T_world_cam, gray.view(), depth.view());
  int wrong = 0;
  for (int y = 0; y < height; ++y) {
    const SE3<double> T = T_world_cam(y);
    for (int x = 0; x < width; ++x) {
      const Vec<double, 3> ray = camera.unproject({double(x), double(y)}).bearing;
      const double z = renderer.scene().intersect(T.p(), T.rotation() * ray) * ray.z();
      if (!(std::abs(z - double(depth.view()(x, y))) < 1e-3 * z))
        ++wrong;  // two rows share a pose: half a row is 0.1 mm
    }
  }
  REQUIRE(wrong < 0.01 * width * height);
  Image<float> still(width, height), still_depth(width, height);
  renderer.render(T_world_cam(0.5 * (height - 1)), still.view(), still_depth.view());
  REQUIRE(still.pixels() != gray.pixels());
  renderer.render_rolling([&](double) { return T_world_cam(0.5 * (height - 1)); }, gray.view(), depth.view());
  REQUIRE(still.pixels() == gray.pixels());  // nothing moves: the same to the bit
  REQUIRE(still_depth.pixels() == depth.pixels());
}

TEST_CASE("renderer: a turning camera with a rolling shutter sees an upright edge aslant, where it projects to") {
  const Pinhole<double> camera{400, 400, 80, 60};
  Scene scene;
  scene.add_rectangle({}, {-2.03, 0, 2}, -Vec<double, 3>::UnitZ(), 4, 40, {Pattern::plain, 0.5f, 0, 1});
  Renderer renderer(scene, camera, width, height, 40);
  Image<float> gray(width, height), depth(width, height);
  const auto R_world_cam = [](double row) { return SO3<double>::exp({0, 2e-4 * (row - 59.5), 0}); };  // 3 rad/s, 8 ms
  renderer.render_rolling(
      [&](double row) {
        return SE3<double>(R_world_cam(row), {0, 0, 0});
      },
      gray.view(), depth.view());
  for (int y = 5; y < height; y += 7) {
    const double ray_y = (y - 60) / 400.0 * 2;
    const Vec<double, 3> p = R_world_cam(y).inverse() * Vec<double, 3>(-0.03, ray_y, 2);
    const double edge_px = 80 + 400 * p.x() / p.z();
    double covered = 0;
    for (int x = 30; x < 110; ++x) covered += double(gray.view()(x, y) / gray.view()(30, y));
    REQUIRE(29.5 + covered == Approx(edge_px).margin(0.08));
  }
}

TEST_CASE("renderer: a surface point keeps its intensity from view to view") {
  const Scene scene = *make_scene("room", 1);
  const Pinhole<double> camera{270, 270, 160, 120};
  Renderer renderer(scene, camera, 320, 240, 2);
  const Trajectory trajectory = *Trajectory::for_scene("room", 1);
  Image<float> gray_a(320, 240), depth_a(320, 240), gray_b(320, 240), depth_b(320, 240);
  const SE3<double> T_a = trajectory.at(5).T_world_body * simulated_T_body_camera();
  const SE3<double> T_b = trajectory.at(5.1).T_world_body * simulated_T_body_camera();
  renderer.render(T_a, gray_a.view(), depth_a.view());
  renderer.render(T_b, gray_b.view(), depth_b.view());
  std::vector<double> difference, spread;
  for (int y = 10; y < 230; y += 3) {
    for (int x = 10; x < 310; x += 3) {
      const double z = double(depth_a.view()(x, y));
      const Vec<double, 3> ray = camera.unproject({double(x), double(y)}).bearing;
      const Projection<double> seen = camera.project(T_b.inverse() * (T_a * Vec<double, 3>(ray / ray.z() * z)));
      if (!seen.valid || !gray_b.view().contains(seen.uv.x(), seen.uv.y(), 2.0)) continue;
      const double value = interpolate(gray_b.view(), seen.uv.x(), seen.uv.y());
      difference.push_back(std::abs(value - double(gray_a.view()(x, y))));
      spread.push_back(std::abs(double(gray_a.view()(x + 2, y) - gray_a.view()(x, y))));
    }
  }
  REQUIRE(difference.size() > 5000);
  const auto median = [](std::vector<double>& x) {
    std::nth_element(x.begin(), x.begin() + x.size() / 2, x.end());
    return x[x.size() / 2];
  };
  const double typical_difference = median(difference), typical_spread = median(spread);
  REQUIRE(typical_difference < 1.0);                   // gray levels
  REQUIRE(typical_difference < 0.3 * typical_spread);  // far below what two pixels of shift would do
}
