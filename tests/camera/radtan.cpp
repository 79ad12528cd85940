#include "plumbline/camera/radtan.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

namespace {

struct Calibration {
  const char* name;
  int width, height;
  double fx, fy, cx, cy, k1, k2, p1, p2, k3;
};

constexpr Calibration calibrations[] = {
    {"EuRoC cam0", 752, 480, 458.654, 457.296, 367.215, 248.375, -0.28340811, 0.07395907, 0.00019359, 1.76187114e-05,
     0},
    {"TUM fr1", 640, 480, 517.306408, 516.469215, 318.643040, 255.313989, 0.262383, -0.953104, -0.005358, 0.002628,
     1.163314},
    {"TUM fr2", 640, 480, 520.908620, 521.007327, 325.141442, 249.701764, 0.231222, -0.784899, -0.003257, -0.000105,
     0.917205},
};

}  // namespace

TEMPLATE_TEST_CASE("radtan: camera suite", "", float, double) {
  for (const Calibration& c : calibrations) {
    INFO(c.name);
    const auto make = [&](auto s) {
      using S = decltype(s);
      return Pinhole<S, RadTan>{S(c.fx), S(c.fy), S(c.cx), S(c.cy), {S(c.k1), S(c.k2), S(c.p1), S(c.p2), S(c.k3)}};
    };
    testing::check_camera<TestType>(make, c.width, c.height, c.cx, c.cy);
  }
}

TEMPLATE_TEST_CASE("radtan: every pixel of TUM fr1 round-trips", "", float, double) {
  using S = TestType;
  const Calibration& c = calibrations[1];
  const Pinhole<S, RadTan> camera{S(c.fx), S(c.fy), S(c.cx), S(c.cy), {S(c.k1), S(c.k2), S(c.p1), S(c.p2), S(c.k3)}};
  double worst = 0;
  for (int v = 0; v < c.height; ++v) {
    for (int u = 0; u < c.width; ++u) {
      const Vec<S, 2> uv{S(u), S(v)};
      const Unprojection<S> ray = camera.unproject(uv);
      REQUIRE(ray.valid);
      const Projection<S> pixel = camera.project(ray.bearing);
      REQUIRE(pixel.valid);
      worst = std::max(worst, double((pixel.uv - uv).norm()));
    }
  }
  CHECK(worst < (std::is_same_v<S, float> ? 1e-3 : 1e-10));
}

TEMPLATE_TEST_CASE("radtan: Jacobians of the distortion and of its inverse", "", float, double) {
  using S = TestType;
  const Calibration& c = calibrations[1];
  const RadTan<S> lens{S(c.k1), S(c.k2), S(c.p1), S(c.p2), S(c.k3)};
  const RadTan<double> exact{c.k1, c.k2, c.p1, c.p2, c.k3};
  for (double x = -0.6; x <= 0.6; x += 0.1) {
    for (double y = -0.45; y <= 0.45; y += 0.1) {
      const Vec<double, 2> m(x, y);
      const auto forward = lens.distort(m.cast<S>());
      const auto back = lens.undistort(forward.m);
      REQUIRE(forward.valid);
      REQUIRE(back.valid);
      CHECK((back.m - m.cast<S>()).norm() < (std::is_same_v<S, float> ? S(1e-6) : S(1e-14)));
      const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-9;
      CHECK(testing::jacobian_error(
                forward.J, [&](const Vec<double, 2>& p) { return exact.distort(p).m; }, m) < tolerance);
      CHECK((forward.J * back.J - Mat<S, 2, 2>::Identity()).norm() < S(tolerance));
    }
  }
}

TEMPLATE_TEST_CASE("radtan: rejects beyond the turning point of the radius", "", float, double) {
  using S = TestType;
  const RadTan<S> lens(S(-0.3), 0, 0, 0);  // r (1 - 0.3 r^2) turns back at r = 1/sqrt(0.9), where it is 0.7027
  CHECK(double(lens.r_max()) == Approx(1.0540925533894598).epsilon(1e-6));
  CHECK(lens.distort({S(1.05), 0}).valid);
  CHECK(!lens.distort({S(1.06), 0}).valid);
  CHECK(!lens.distort({S(0.8), S(0.8)}).valid);
  const auto inside = lens.undistort({S(0.70), 0}), outside = lens.undistort({S(0.71), 0});
  REQUIRE(inside.valid);
  CHECK(inside.m.x() < lens.r_max());
  CHECK(!outside.valid);
  for (S r = S(0.71); r < S(40); r *= S(1.3)) CHECK(!lens.undistort({r, S(-0.3) * r}).valid);
  CHECK(RadTan<S>().r_max() == RadTan<S>::r_limit);
}
