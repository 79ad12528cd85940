#include "plumbline/residual/line_observation.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/camera/equidistant.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/lines.hpp"

using namespace plumbline;
using test::LineScene;

namespace {

template <class S, class Measurement>
void check_jacobians(const Measurement& measurement, const Plucker<double>& line, double tolerance) {
  const auto lin = test::cast<S>(measurement).linearize({line.n.cast<S>(), line.v.cast<S>()});
  REQUIRE(lin.valid);
  REQUIRE((lin.r.template cast<double>() - measurement.residual(line)).norm() <
          tolerance * (1 + measurement.residual(line).norm()));
  REQUIRE(testing::jacobian_error(
              lin.J_r_n,
              [&](const Vec<double, 3>& n) {
                return measurement.residual({n, line.v});
              },
              line.n, 1e-5) < tolerance);
  REQUIRE(testing::jacobian_error(
              lin.J_r_v,
              [&](const Vec<double, 3>& v) {
                return measurement.residual({line.n, v});
              },
              line.v, 1e-5) < tolerance);
}

/// Endpoints moved off the image of a line by a known number of pixels.
template <class Camera>
void check_pixels(const Camera& camera) {
  Random random(4);
  int checked = 0;
  for (int i = 0; i < 100; ++i) {
    const Vec<double, 3> p = test::random_vector(random, 1.2) + Vec<double, 3>(0, 0, 2);
    const Vec<double, 3> q = test::random_vector(random, 1.2) + Vec<double, 3>(0, 0, 2);
    const auto at_p = camera.project(p), at_q = camera.project(q);
    if (!at_p.valid || !at_q.valid || (at_p.uv - at_q.uv).norm() < 50) continue;
    const Plucker<double> line = Line3<double>::through(p, q).plucker();
    // across the image of the line: where the line's plane changes fastest
    const Vec<double, 2> across =
        bearing_jacobian(camera.project(p.normalized()).J_uv_p).transpose() * line.n.normalized();
    for (const double off_px : {-0.7, 0.0, 0.4}) {
      const auto seen = observe_line(camera, at_p.uv + off_px * across.normalized(), at_q.uv);
      REQUIRE(seen.valid);
      const Vec<double, 2> r = seen.reprojection.residual(line);
      REQUIRE(r[0] == Approx(off_px).epsilon(0.02).margin(1e-7));
      REQUIRE(std::abs(r[1]) < 1e-7);
      ++checked;
    }
  }
  REQUIRE(checked > 100);
}

}  // namespace

TEST_CASE("line_observation: the residual is the distance in pixels, for every camera") {
  check_pixels(Pinhole<double>{458, 457, 367, 248, {}});
  check_pixels(Pinhole<double, RadTan>{458, 457, 367, 248, {-0.28, 0.07, 2e-4, 1e-4}});
  check_pixels(Equidistant<double>(380, 381, 370, 250, -0.01, 0.02, -0.01, 0.002));
}

TEST_CASE("line_observation: inverse depth of a point of the line") {
  const Vec<double, 3> p(0.3, -0.2, 2), q(-0.5, 0.6, 4);
  const Plucker<double> line = Line3<double>::through(p, q).plucker();
  const LineInverseDepth<double> depth{p / p.z(), q / q.z(), {0.4, 0.3}};
  REQUIRE(depth.residual(line)[0] == Approx(0.5 - 0.4));
  REQUIRE(depth.residual(line)[1] == Approx(0.25 - 0.3));
}

TEMPLATE_TEST_CASE("line_observation: Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-7;
  for (const auto kind : {LineScene::ordinary, LineScene::near_center, LineScene::along_view}) {
    for (std::uint64_t seed = 1; seed < 60; ++seed) {
      const LineScene s(seed, kind);
      const SE3<double> T = (s.T_world_target * s.T_body_cam).inverse() * (s.T_world_anchor * s.T_body_cam);
      const Plucker<double> line = (T * s.line).plucker();
      check_jacobians<S>(s.pixels, line, tolerance);
      check_jacobians<S>(s.depth, line, tolerance);
    }
  }
}

TEST_CASE("line_observation: not valid through the center, behind the camera, without length and for NaN") {
  const Pinhole<double> camera{400, 400, 320, 240, {}};
  const auto seen = observe_line(camera, Vec<double, 2>(300, 200), Vec<double, 2>(400, 260));
  REQUIRE(seen.valid);
  const Vec<double, 3> p = 2 * seen.reprojection.bearing_start, q = 3 * seen.reprojection.bearing_end;
  REQUIRE(seen.reprojection.linearize(Line3<double>::through(p, q).plucker()).valid);
  REQUIRE_FALSE(seen.reprojection.linearize(Line3<double>::through(-p, -q).plucker()).valid);
  REQUIRE_FALSE(seen.reprojection.linearize(Line3<double>::through({0.01, 0, 1}, {0.01, 0, 3}).plucker()).valid);
  REQUIRE(seen.reprojection.linearize(Line3<double>::through({0.03, 0, 1}, {0.03, 0, 3}).plucker()).valid);
  REQUIRE_FALSE(seen.reprojection.linearize(Line3<double>::through(p, p).plucker()).valid);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(seen.reprojection.linearize({Vec<double, 3>(nan, 0, 0), p}).valid);
  const LineInverseDepth<double> depth{p / p.z(), q / q.z(), {0.5, 0.3}};
  REQUIRE(depth.linearize(Line3<double>::through(p, q).plucker()).valid);
  REQUIRE_FALSE(depth.linearize(Line3<double>::through(-p, -q).plucker()).valid);
  REQUIRE_FALSE(observe_line(camera, Vec<double, 2>(300, 200), Vec<double, 2>(300, 200)).valid);
  REQUIRE_FALSE(observe_line(camera, Vec<double, 2>(300, nan), Vec<double, 2>(300, 200)).valid);
}
