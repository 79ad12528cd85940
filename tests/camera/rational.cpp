#include "plumbline/camera/rational.hpp"

#include "camera_suite.hpp"
#include "plumbline/camera/radtan.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("rational: camera suite", "", float, double) {
  SECTION("depth camera of 75 degrees") {  // large coefficients that nearly cancel
    const auto make = [](auto s) {
      using S = decltype(s);
      return Pinhole<S, Rational>{
          S(612.6),
          S(612.3),
          S(637.4),
          S(365.9),
          {S(0.564), S(-2.713), S(0.0006), S(-0.0003), S(1.537), S(0.442), S(-2.528), S(1.463)}};
    };
    testing::check_camera<TestType>(make, 1280, 720, 637.4, 365.9);
  }
  SECTION("wide lens") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Pinhole<S, Rational>{
          S(300), S(301), S(320), S(240), {S(4.1), S(2.6), S(1e-4), S(-2e-4), S(0.11), S(4.45), S(3.9), S(0.59)}};
    };
    testing::check_camera<TestType>(make, 640, 480, 320, 240);
  }
}

TEMPLATE_TEST_CASE("rational: a denominator of 1 is the radial-tangential distortion", "", float, double) {
  using S = TestType;
  const Rational<S> rational(S(-0.28), S(0.07), S(2e-4), S(1e-4), S(0.01), 0, 0, 0);
  const RadTan<S> radtan(S(-0.28), S(0.07), S(2e-4), S(1e-4), S(0.01));
  CHECK(double(rational.r_max()) == Approx(double(radtan.r_max())).epsilon(1e-5));
  for (S x = S(-0.8); x < S(0.8); x += S(0.1)) {
    const auto a = rational.distort({x, S(0.3)}), b = radtan.distort({x, S(0.3)});
    CHECK((a.m - b.m).norm() < S(1e-6));
    CHECK((a.J - b.J).norm() < S(1e-5));
  }
}

TEMPLATE_TEST_CASE("rational: Jacobians of the distortion and of its inverse", "", float, double) {
  using S = TestType;
  const Rational<S> lens(S(0.564), S(-2.713), S(0.0006), S(-0.0003), S(1.537), S(0.442), S(-2.528), S(1.463));
  const Rational<double> exact(0.564, -2.713, 0.0006, -0.0003, 1.537, 0.442, -2.528, 1.463);
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-8;
  for (double x = -0.7; x <= 0.7; x += 0.1) {
    for (double y = -0.5; y <= 0.5; y += 0.1) {
      const Vec<double, 2> m(x, y);
      const auto forward = lens.distort(m.cast<S>());
      const auto back = lens.undistort(forward.m);
      REQUIRE(forward.valid);
      REQUIRE(back.valid);
      CHECK(testing::jacobian_error(
                forward.J, [&](const Vec<double, 2>& p) { return exact.distort(p).m; }, m) < tolerance);
      CHECK((forward.J * back.J - Mat<S, 2, 2>::Identity()).norm() < S(tolerance));
    }
  }
}

TEMPLATE_TEST_CASE("rational: rejects beyond the turning point and the pole", "", float, double) {
  using S = TestType;
  const Rational<S> turning(0, 0, 0, 0, 0, 1, 0, 0);  // r/(1 + r^2) turns back at r = 1
  CHECK(double(turning.r_max()) == Approx(1).epsilon(1e-5));
  CHECK(turning.distort({S(0.99), 0}).valid);
  CHECK(!turning.distort({S(1.01), 0}).valid);
  CHECK(turning.undistort({S(0.49), 0}).valid);
  CHECK(!turning.undistort({S(0.51), 0}).valid);
  const Rational<S> pole(0, 0, 0, 0, 0, S(-0.25), 0, 0);  // r/(1 - r^2/4)
  CHECK(double(pole.r_max()) == Approx(2).epsilon(1e-5));
  CHECK(!pole.distort({S(2.1), 0}).valid);
}
