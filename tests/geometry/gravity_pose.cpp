#include "plumbline/geometry/gravity_pose.hpp"

#include <algorithm>
#include <limits>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

namespace {

constexpr int trials = 5000;

double symmetric(Random& random) { return 2 * random.uniform() - 1; }

/// A camera of any attitude, features 1 to 8 m in front of it.
template <class S>
struct World {
  Random random;
  SE3<double> T_cam_world;

  explicit World(std::uint64_t seed) : random(seed) { move(); }
  void move() {
    Vec<double, 6> xi;
    for (int k = 0; k < 6; ++k) xi[k] = (k < 3 ? 1.7 : 5) * symmetric(random);
    T_cam_world = SE3<double>::exp(xi);
  }
  Vec<S, 3> up() const { return (T_cam_world.rotation() * Vec<double, 3>(0, 0, 1)).template cast<S>(); }
  Vec<double, 3> p_cam() {
    const double z = 1 + 7 * random.uniform();
    return {z * symmetric(random), z * symmetric(random), z};
  }
  Vec<double, 3> noise(double sigma) {
    return sigma * std::sqrt(3) * Vec<double, 3>(symmetric(random), symmetric(random), symmetric(random));
  }
  GravityPosePoint<S> point(const Vec<double, 3>& p, double sigma = 0) {
    const Vec<double, 3> bearing = (p.normalized() + noise(sigma)).normalized();
    return {bearing.cast<S>(), (T_cam_world.inverse() * p).template cast<S>()};
  }
  GravityPosePoint<S> point(double sigma = 0) { return point(p_cam(), sigma); }
  GravityPoseLine<S> line(const Vec<double, 3>& p, const Vec<double, 3>& q, double sigma = 0) {
    const Vec<double, 3> normal = (p.cross(q).normalized() + noise(sigma)).normalized();
    const SE3<double> T_world_cam = T_cam_world.inverse();
    return {normal.cast<S>(), {(T_world_cam * p).template cast<S>(), (T_world_cam * q).template cast<S>()}};
  }
  GravityPoseLine<S> line(double sigma = 0) {
    const Vec<double, 3> p = p_cam();
    return line(p, p_cam(), sigma);
  }
  double error(const SE3<S>& T) const { return minus(T.template cast<double>(), T_cam_world).norm(); }
  double error(const FixedVector<SE3<S>, 2>& candidates) const {
    double best = std::numeric_limits<double>::infinity();
    for (const SE3<S>& T : candidates) best = std::min(best, error(T));
    return best;
  }
};

template <class S>
constexpr bool is_float = std::is_same_v<S, float>;

}  // namespace

TEMPLATE_TEST_CASE("gravity_pose: two points, the true pose is among the candidates", "", float, double) {
  using S = TestType;
  World<S> world(1);
  int missed = 0, candidates = 0;
  for (int i = 0; i < trials; ++i) {
    world.move();
    const std::array<GravityPosePoint<S>, 2> points{world.point(), world.point()};
    const FixedVector<SE3<S>, 2> found = gravity_pose(world.up(), points);
    candidates += int(found.size());
    missed += !(world.error(found) < (is_float<S> ? 2e-2 : 1e-6));
    for (const SE3<S>& T : found) {
      REQUIRE((T.rotation() * Vec<S, 3>(0, 0, 1) - world.up()).norm() < (is_float<S> ? S(1e-5) : S(1e-13)));
      for (const auto& point : points) {
        REQUIRE((normalized(Vec<S, 3>(T * point.p_world)) - point.bearing).norm() < (is_float<S> ? S(2e-2) : S(1e-7)));
      }
    }
  }
  CAPTURE(missed, candidates);
  CHECK(missed < trials * (is_float<S> ? 0.02 : 2e-3));  // near double solutions and degenerate samples
  CHECK(candidates > trials);
  CHECK(candidates < 2 * trials);
}

TEMPLATE_TEST_CASE("gravity_pose: a point and a line, the true pose is among the candidates", "", float, double) {
  using S = TestType;
  World<S> world(2);
  int missed = 0;
  for (int i = 0; i < trials; ++i) {
    world.move();
    const auto point = world.point();
    const auto line = world.line();
    const FixedVector<SE3<S>, 2> found = gravity_pose(world.up(), point, line);
    missed += !(world.error(found) < (is_float<S> ? 5e-2 : 1e-5));
    for (const SE3<S>& T : found) {
      REQUIRE(T.is_finite());
      if (world.error(T) > 1e4) continue;  // almost degenerate
      for (const Vec<S, 3>& p : line.points_world) {
        REQUIRE(std::abs(dot(line.normal, normalized(Vec<S, 3>(T * p)))) < (is_float<S> ? S(2e-2) : S(1e-7)));
      }
    }
  }
  CAPTURE(missed);
  CHECK(missed < trials * (is_float<S> ? 0.03 : 5e-3));
}

TEMPLATE_TEST_CASE("gravity_pose: least squares of points and lines, exact and with noise", "", float, double) {
  using S = TestType;
  World<S> world(3);
  const double sigma = 1e-3;
  double minimal = 0, fitted = 0;
  int worse = 0;
  for (int i = 0; i < 300; ++i) {
    world.move();
    for (const auto& [n_points, n_lines] : {std::pair{3, 0}, {0, 4}, {1, 2}, {20, 0}, {10, 10}}) {
      std::vector<GravityPosePoint<S>> exact_points, points;
      std::vector<GravityPoseLine<S>> exact_lines, lines;
      for (int k = 0; k < n_points; ++k) {
        const Vec<double, 3> p = world.p_cam();
        exact_points.push_back(world.point(p));
        points.push_back(world.point(p, sigma));
      }
      for (int k = 0; k < n_lines; ++k) {
        const Vec<double, 3> p = world.p_cam(), q = world.p_cam();
        exact_lines.push_back(world.line(p, q));
        lines.push_back(world.line(p, q, sigma));
      }
      const GravityPoseFit<S> exact = gravity_pose_least_squares<S>(world.up(), exact_points, exact_lines);
      worse += !(exact.valid && world.error(exact.T_cam_world) < (is_float<S> ? 2e-2 : 1e-6));
      const GravityPoseFit<S> noisy = gravity_pose_least_squares<S>(world.up(), points, lines);
      if (n_points == 20) {
        REQUIRE(noisy.valid);
        const double best = world.error(gravity_pose(world.up(), std::array{points[0], points[1]}));
        minimal += std::min(best, 1.0);
        fitted += world.error(noisy.T_cam_world);
      }
    }
  }
  CAPTURE(worse, minimal / 300, fitted / 300);
  CHECK(worse < 1500 * (is_float<S> ? 0.02 : 2e-3));
  CHECK(fitted / 300 < 5e-3);
  CHECK(fitted < 0.2 * minimal);
}

TEMPLATE_TEST_CASE("gravity_pose: degenerate samples give none", "", float, double) {
  using S = TestType;
  World<S> world(4);
  int accepted = 0;
  for (int i = 0; i < 500; ++i) {
    world.move();
    const Vec<double, 3> up = world.up().template cast<double>(), p = world.p_cam(), q = world.p_cam();
    const auto point = world.point(p);
    const Vec<S, 3> u = world.up();
    // Points: coincident, above one another, with equal bearings.
    CHECK(gravity_pose(u, std::array{point, point}).empty());
    accepted += !gravity_pose(u, std::array{point, world.point(p + 0.8 * up)}).empty();
    GravityPosePoint<S> same_bearing = world.point(1.7 * p);
    same_bearing.bearing = point.bearing;
    accepted += !gravity_pose(u, std::array{point, same_bearing}).empty();
    // Lines: parallel to gravity, of coincident points, in one plane with the point and the camera.
    accepted += !gravity_pose(u, point, world.line(q, q + up)).empty();
    GravityPoseLine<S> no_line = world.line(q, p);
    no_line.points_world[1] = no_line.points_world[0];
    accepted += !gravity_pose(u, point, no_line).empty();
    accepted += !gravity_pose(u, point, world.line(2 * p, q)).empty();
    // Least squares: too few, two lines, all of them parallel to gravity, all points above one another.
    const std::array<GravityPoseLine<S>, 2> two{world.line(), world.line()};
    CHECK(!gravity_pose_least_squares<S>(u, {}, two).valid);
    const std::array<GravityPoseLine<S>, 3> vertical{world.line(p, p + up), world.line(q, q - up),
                                                     world.line(p + q, p + q + up)};
    accepted += gravity_pose_least_squares<S>(u, {}, vertical).valid;
    const std::array<GravityPosePoint<S>, 3> tower{point, world.point(p + 0.3 * up), world.point(p - 0.4 * up)};
    accepted += gravity_pose_least_squares<S>(u, tower).valid;
  }
  CHECK(accepted < 500 * 8 * (is_float<S> ? 0.01 : 0.001));  // rounding
}

TEMPLATE_TEST_CASE("gravity_pose: NaN, infinity and zero give none", "", float, double) {
  using S = TestType;
  World<S> world(5);
  const std::array<GravityPosePoint<S>, 2> good{world.point(), world.point()};
  const auto line = world.line();
  const Vec<S, 3> up = world.up(), zero = Vec<S, 3>::Zero();
  for (const S bad : {std::numeric_limits<S>::quiet_NaN(), std::numeric_limits<S>::infinity()}) {
    for (int k = 0; k < 3; ++k) {
      Vec<S, 3> bad_up = up;
      bad_up[k] = bad;
      CHECK(gravity_pose(bad_up, good).empty());
      CHECK(gravity_pose(bad_up, good[0], line).empty());
      for (std::size_t i = 0; i < 2; ++i) {
        auto broken = good;
        broken[i].p_world[k] = bad;
        CHECK(gravity_pose(up, broken).empty());
        broken = good;
        broken[i].bearing[k] = bad;
        CHECK(gravity_pose(up, broken).empty());
        auto broken_line = line;
        broken_line.points_world[i][k] = bad;
        CHECK(gravity_pose(up, good[0], broken_line).empty());
      }
      auto broken_line = line;
      broken_line.normal[k] = bad;
      CHECK(gravity_pose(up, good[0], broken_line).empty());
      const std::array<GravityPosePoint<S>, 3> three{good[0], good[1], {good[0].bearing, Vec<S, 3>(1, bad, 2)}};
      CHECK(!gravity_pose_least_squares<S>(up, three).valid);
    }
  }
  CHECK(gravity_pose(zero, good).empty());
  CHECK(gravity_pose(up, std::array{good[0], GravityPosePoint<S>{zero, good[1].p_world}}).empty());
  CHECK(gravity_pose(up, good[0], GravityPoseLine<S>{zero, line.points_world}).empty());
  CHECK(!gravity_pose_least_squares<S>(up, {}).valid);
}
