#include "line_assisted_epnp.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using test::line_assisted_epnp;
using test::LineAssistedPose;
using test::PointOnSegment;

namespace {

double symmetric(Random& random) { return 2 * random.uniform() - 1; }

template <class S>
struct Scene {
  SE3<double> T_cam_world;
  std::vector<PoseCorrespondence<S>> points;
  std::vector<PointOnSegment<S>> on_segments;
};

/// Points, and lines with `members` collinear points each, at 1 to 7 m; with `thickness` < 1 they are near the plane
/// z = 0 of the world. Noise in radians.
template <class S>
Scene<S> make_scene(std::uint64_t seed, int points, int lines, int members, double noise, double thickness = 1) {
  Random random(seed);
  testing::Gaussian gaussian(seed + 1000);
  Scene<S> scene;
  const SE3<double> T_plane_cam(SO3<double>::exp({0.5 * symmetric(random), 0.5 * symmetric(random), symmetric(random)}),
                                Vec<double, 3>(0.2, 0.1, -4));
  scene.T_cam_world = thickness < 1 ? T_plane_cam.inverse() : SE3<double>();
  if (!(thickness < 1)) {
    Vec<double, 6> xi;
    for (int i = 0; i < 6; ++i) xi[i] = 1.5 * symmetric(random);
    scene.T_cam_world = SE3<double>::exp(xi);
  }
  const SE3<double> T_world_cam = scene.T_cam_world.inverse();
  const auto place = [&]() -> Vec<double, 3> {  // in the world
    if (thickness < 1)
      return Vec<double, 3>(1.8 * symmetric(random), 1.4 * symmetric(random), thickness * symmetric(random));
    const double z = 1 + 6 * random.uniform();
    return T_world_cam * Vec<double, 3>(0.8 * z * symmetric(random), 0.6 * z * symmetric(random), z);
  };
  const double sigma = std::max(noise, 1e-3);
  const auto bearing_of = [&](const Vec<double, 3>& p_world) -> Vec<double, 3> {
    const Vec<double, 3> b = (scene.T_cam_world * p_world).normalized();
    const Vec<double, 3> e{gaussian(), gaussian(), gaussian()};
    return Vec<double, 3>((b + noise * (e - b * b.dot(e))).normalized());
  };
  const auto add_point = [&](const Vec<double, 3>& p) {
    scene.points.push_back({cast_to<S>(bearing_of(p)), cast_to<S>(p), S(sigma)});
  };
  for (int i = 0; i < points; ++i) add_point(place());
  for (int i = 0; i < lines; ++i) {
    const Vec<double, 3> p = place(), q = place();
    const Vec<double, 3> normal = bearing_of(p).cross(bearing_of(q)).normalized();
    for (const Vec<double, 3>& end : {p, q}) scene.on_segments.push_back({normal.cast<S>(), end.cast<S>(), S(sigma)});
    for (int k = 0; k < members; ++k) {
      const Vec<double, 3> x = p + random.uniform() * (q - p);
      scene.on_segments.push_back({normal.cast<S>(), x.cast<S>(), S(sigma)});
      add_point(x);
    }
  }
  return scene;
}

template <class S>
LineAssistedPose<S> solve(const Scene<S>& scene) {
  return line_assisted_epnp<S>(scene.points, scene.on_segments);
}
template <class S>
Vec<double, 6> error_of(const SE3<S>& T_cam_world, const Scene<S>& scene) {
  return minus(T_cam_world.template cast<double>(), scene.T_cam_world);
}

/// Gauss-Newton on the angles of all rows: the pose of maximum likelihood near T, and how far its noise lets it be.
struct Optimum {
  SE3<double> T_cam_world;
  Mat<double, 6, 6> information;
};
template <class S>
Optimum optimum(const Scene<S>& scene, SE3<double> T) {
  const test::LineAssistedRows<S> problem{scene.points, scene.on_segments};
  Optimum out{T, {}};
  for (int iteration = 0; iteration < 15; ++iteration) {
    DenseNormalEquations<double, 6> equations;
    problem.for_each_row([&](const Vec<S, 3>& normal, const Vec<S, 3>& p_world, S sigma) {
      const Vec<double, 3> n = normal.template cast<double>(), p = p_world.template cast<double>();
      const auto f = [&](const SE3<double>& X) -> Vec<double, 1> {
        return Vec<double, 1>(n.dot((X * p).normalized()));
      };
      Mat<double, 1, 6> J;
      for (int k = 0; k < 6; ++k) {
        Vec<double, 6> d = Vec<double, 6>::Zero();
        d[k] = 1e-6;
        J(0, k) = (f(plus(T, d))[0] - f(plus(T, Vec<double, 6>(-d)))[0]) / 2e-6;
      }
      equations.add(J, f(T), 1 / (double(sigma) * double(sigma)));
    });
    Vec<double, 6> d;
    REQUIRE(equations.solve(d));
    T = plus(T, d);
    out = {T, equations.H()};
  }
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("line_assisted_epnp: exact data", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-3 : 1e-8;
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    for (const double thickness : {1.0, 0.0}) {
      for (const auto& scene : {make_scene<S>(seed, 12, 0, 0, 0, thickness), make_scene<S>(seed, 8, 6, 0, 0, thickness),
                                make_scene<S>(seed, 6, 4, 2, 0, thickness)}) {
        const auto pose = solve(scene);
        REQUIRE(pose.valid);
        worst = std::max(worst, error_of(pose.T_cam_world, scene).norm());
        CAPTURE(seed, thickness, scene.points.size(), error_of(pose.T_cam_world, scene).norm());
        CHECK(error_of(pose.T_cam_world, scene).norm() < tolerance);
      }
    }
  }
  CAPTURE(worst);
  CHECK(worst < tolerance);
}

TEMPLATE_TEST_CASE("line_assisted_epnp: lines alone tell the pose", "", float, double) {
  using S = TestType;
  int right = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const auto scene = make_scene<S>(seed, 0, 10, 0, 0);
    const auto pose = solve(scene);
    right += pose.valid && error_of(pose.T_cam_world, scene).norm() < (std::is_same_v<S, float> ? 1e-2 : 1e-6);
  }
  CHECK(right == 50);
}

TEMPLATE_TEST_CASE("line_assisted_epnp: with noise it is near the optimum, nearer with the rows of lines", "", float,
                   double) {
  using S = TestType;
  constexpr double noise = 2e-3;
  for (const double thickness : {1.0, 0.2, 0.02, 0.0}) {
    double nees = 0, of_points = 0, of_all = 0;
    constexpr int trials = 60;
    int near = 0;
    for (std::uint64_t seed = 1; seed <= trials; ++seed) {
      auto scene = make_scene<S>(seed, 10, 8, 1, noise, thickness);
      const auto pose = solve(scene);
      REQUIRE(pose.valid);
      const Optimum best = optimum(scene, scene.T_cam_world);
      const Vec<double, 6> d = minus(pose.T_cam_world.template cast<double>(), best.T_cam_world);
      const double distance2 = d.dot(best.information * d);  // expected of the optimum to the truth: 6
      nees += distance2 / trials;
      near += distance2 < 16.8;  // 99 %
      of_all += error_of(pose.T_cam_world, scene).squaredNorm();
      scene.on_segments.clear();
      const auto alone = solve(scene);
      REQUIRE(alone.valid);
      of_points += error_of(alone.T_cam_world, scene).squaredNorm();
    }
    CAPTURE(thickness, nees, near, of_points, of_all);
    CHECK(near >= trials * 9 / 10);
    CHECK(of_all < of_points);
  }
}

TEMPLATE_TEST_CASE("line_assisted_epnp: too few rows, one line, NaN", "", float, double) {
  using S = TestType;
  CHECK(!line_assisted_epnp<S>({}, {}).valid);
  CHECK(!solve(make_scene<S>(3, 5, 0, 0, 0)).valid);  // ten rows
  CHECK(solve(make_scene<S>(3, 6, 0, 0, 0)).valid);
  CHECK(solve(make_scene<S>(3, 4, 0, 0, 0, 0.0)).valid);
  CHECK(!solve(make_scene<S>(3, 3, 0, 0, 0, 0.0)).valid);
  CHECK(!solve(make_scene<S>(3, 0, 1, 12, 0)).valid);  // all on one line

  auto scene = make_scene<S>(5, 20, 6, 1, 0);
  const S nan = std::numeric_limits<S>::quiet_NaN(), infinite = std::numeric_limits<S>::infinity();
  scene.points[1].bearing.x() = nan;
  scene.points[2].p_world.y() = infinite;
  scene.points[3].sigma_rad = nan;
  scene.points[4].sigma_rad = S(0);
  scene.on_segments[1].normal.z() = nan;
  scene.on_segments[2].p_world.x() = nan;
  const auto pose = solve(scene);
  REQUIRE(pose.valid);
  CHECK(error_of(pose.T_cam_world, scene).norm() < (std::is_same_v<S, float> ? 2e-3 : 1e-8));

  for (auto& c : scene.points) c.bearing.x() = nan;
  for (auto& c : scene.on_segments) c.sigma_rad = nan;
  CHECK(!solve(scene).valid);
}
