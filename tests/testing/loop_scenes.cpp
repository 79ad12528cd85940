#include "plumbline/testing/loop_scenes.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <set>
#include <string_view>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/testing/renderer.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;
using namespace plumbline::testing;

namespace {

bool equal(const Material& a, const Material& b) {
  return a.pattern == b.pattern && a.base == b.base && a.contrast == b.contrast && a.seed == b.seed;
}

/// How many rectangles have their middle in `inside` and no equal one, material included, at that shift.
template <class Inside>
int without_copy(const Scene& scene, const Vec<double, 3>& shift, Inside&& inside) {
  return int(std::count_if(scene.rectangles.begin(), scene.rectangles.end(), [&](const Rectangle& r) {
    const Vec<double, 3> middle = r.origin + 0.5 * r.width * r.e_u + 0.5 * r.height * r.e_v;
    return inside(middle) && std::none_of(scene.rectangles.begin(), scene.rectangles.end(), [&](const Rectangle& o) {
             return (o.origin - r.origin - shift).norm() < 1e-9 && o.e_u.isApprox(r.e_u) && o.e_v.isApprox(r.e_v) &&
                    std::abs(o.width - r.width) < 1e-9 && std::abs(o.height - r.height) < 1e-9 &&
                    equal(o.material, r.material);
           });
  }));
}

struct Difference {
  float gray = 0, depth = 0;  ///< largest: levels, [m]
};

/// Images of a camera that looks along yaw. Surfaces further than 6 m from `middle` are left out: baking takes long.
class Views {
 public:
  Views(const Scene& scene, const Vec<double, 3>& middle)
      : renderer_(near(scene, middle), Pinhole<double>{80, 80, 47.5, 35.5}, width, height, 6) {}

  /// Between the image at p and that at p + shift.
  Difference largest_difference(const Vec<double, 3>& p, double yaw, const Vec<double, 3>& shift) {
    Image<float> gray_a(width, height), depth_a(width, height), gray_b(width, height), depth_b(width, height);
    render(p, yaw, gray_a, depth_a);
    render(p + shift, yaw, gray_b, depth_b);
    Difference out;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        out.gray = std::max(out.gray, std::abs(gray_a.view().row(y)[x] - gray_b.view().row(y)[x]));
        out.depth = std::max(out.depth, std::abs(depth_a.view().row(y)[x] - depth_b.view().row(y)[x]));
      }
    }
    return out;
  }

 private:
  static constexpr int width = 96, height = 72;

  static Scene near(Scene scene, const Vec<double, 3>& middle) {
    std::erase_if(scene.rectangles, [&](const Rectangle& r) { return r.distance(middle) > 6; });
    return scene;
  }
  void render(const Vec<double, 3>& p, double yaw, Image<float>& gray, Image<float>& depth) {
    const SE3<double> T_world_body = placement(p.x(), p.y(), p.z(), yaw);
    renderer_.render(T_world_body * simulated_T_body_camera(), gray.view(), depth.view());
  }

  Renderer renderer_;
};

constexpr double pi = std::numbers::pi;

}  // namespace

TEST_CASE("loop_scenes: doors repeat in shape, material and image after a cell") {
  using Ring = RingCorridor;
  const Scene scene = *make_scene("doors", 5);
  const double west = 2 * Ring::cell - Ring::hx, east = Ring::hx - 3 * Ring::cell;
  const auto between_corners = [&](const Vec<double, 3>& p) {
    return p.y() < -Ring::by && p.x() > west && p.x() < east;
  };
  REQUIRE(without_copy(scene, {Ring::cell, 0, 0}, between_corners) == 0);
  REQUIRE(without_copy(scene, {0.9 * Ring::cell, 0, 0}, between_corners) > 50);
  const Vec<double, 3> p(-Ring::cell, -RingPath::width / 2, 1.4);
  Views views(scene, p);
  const Difference copy = views.largest_difference(p, -pi / 2 + 0.2, {Ring::cell, 0, 0});
  REQUIRE(copy.gray < 1.5f);  // rounding of texels
  REQUIRE(copy.depth < 1e-4f);
  REQUIRE(views.largest_difference(p, -pi / 2 + 0.2, {0.5 * Ring::cell, 0, 0}).gray > 20);
}

TEST_CASE("loop_scenes: all doors of the ring are equal") {
  using Ring = RingCorridor;
  const Scene scene = *make_scene("doors", 5);
  std::set<std::uint32_t> seeds;
  for (const Rectangle& r : scene.rectangles) seeds.insert(r.material.seed);
  REQUIRE(seeds.size() < 10);  // those of one cell
  int cells = 0;
  for (const Ring::Wall& wall : Ring::walls()) cells += wall.cells;
  REQUIRE(cells == 40);
}

TEST_CASE("loop_scenes: the facade repeats in shape, material and image after a period, all along the path") {
  const Scene scene = *make_scene("tiles", 5);
  REQUIRE(without_copy(scene, {Facade::period, 0, 0}, [](const Vec<double, 3>& p) {
            return p.x() > -Facade::half && p.x() < Facade::half - Facade::period - 0.01;
          }) == 0);
  for (const double x : {-11.9, 0.3, 8.0}) {
    Views views(scene, {x, 0, 1.4});
    const Difference copy = views.largest_difference({x, 0, 1.4}, pi / 2 + 0.2, {2 * Facade::period, 0, 0});
    REQUIRE(copy.gray < 1.5f);
    REQUIRE(copy.depth < 1e-4f);
  }
  const Vec<double, 3> p(0, 0, 1.4);
  REQUIRE(Views(scene, p).largest_difference(p, pi / 2, {0.5 * Facade::period, 0, 0}).gray > 20);
}

TEST_CASE("loop_scenes: no two places of the ring are alike") {
  const Scene scene = *make_scene("ring", 5);
  std::set<std::uint32_t> pictures;
  int count = 0;
  for (const Rectangle& r : scene.rectangles) {
    if (r.material.pattern != Pattern::poster) continue;
    pictures.insert(r.material.seed);
    ++count;
  }
  REQUIRE(count > 100);
  REQUIRE(int(pictures.size()) == count);
  const Vec<double, 3> cell(RingCorridor::cell, 0, 0), p(-5, -RingPath::width / 2, 1.4);
  Views views(scene, p);
  for (int i = 1; i < 3; ++i) REQUIRE(views.largest_difference(p, -pi / 2, i * cell).gray > 20);
}

TEST_CASE("loop_scenes: the camera stays in the corridor and between the facades, and looks at them") {
  for (const char* name : {"ring", "doors", "tiles"}) {
    const bool facade = std::string_view(name) == "tiles";
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Trajectory trajectory = *Trajectory::for_scene(name, seed);
      for (double t = 0; t < trajectory.end_of_lap_s(3); t += 0.1) {
        const SE3<double> T = trajectory.at(t).T_world_body;
        const double x = std::abs(T.p().x()), y = std::abs(T.p().y());
        if (facade) {  // no end of the facade in an image
          REQUIRE((x < 12.1 && y < 0.1));
          REQUIRE((T.rotation() * Vec<double, 3>(1, 0, 0)).y() > 0.9);
        } else {
          REQUIRE((x < RingCorridor::hx - 1 && y < RingCorridor::hy - 1));
          REQUIRE(std::max(x - RingCorridor::bx, y - RingCorridor::by) > 0.9);
        }
      }
    }
  }
}
