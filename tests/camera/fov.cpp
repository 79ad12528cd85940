#include "plumbline/camera/fov.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("fov: camera suite", "", float, double) {
  const double w = GENERATE(0.93, 0.3, 1.4, 0.0);
  CAPTURE(w);
  const auto make = [&](auto s) {
    using S = decltype(s);
    return Pinhole<S, Fov>{S(400), S(402), S(320), S(240), {S(w)}};
  };
  testing::check_camera<TestType>(make, 640, 480, 320, 240);
}

TEMPLATE_TEST_CASE("fov: known values", "", float, double) {
  using S = TestType;
  const Fov<S> lens(S(0.9));
  const double expected = std::atan(2 * 0.5 * std::tan(0.45)) / 0.9;
  const auto distorted = lens.distort({S(0.3), S(0.4)});
  REQUIRE(distorted.valid);
  CHECK(double(distorted.m.norm()) == Approx(expected));
  CHECK(lens.undistort({S(1.74), 0}).valid);
  CHECK(!lens.undistort({S(1.75), 0}).valid);  // 1.745 = pi/2 / 0.9
}

TEMPLATE_TEST_CASE("fov: Jacobians of the distortion and of its inverse", "", float, double) {
  using S = TestType;
  const Fov<S> lens(S(0.93));
  const Fov<double> exact(0.93);
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-8;
  for (double x = -1.5; x <= 1.5; x += 0.25) {
    for (double y = -1; y <= 1; y += 0.25) {
      const Vec<double, 2> m(x, y);
      const auto forward = lens.distort(m.cast<S>());
      const auto back = lens.undistort(forward.m);
      REQUIRE((forward.valid && back.valid));
      CHECK((back.m - m.cast<S>()).norm() < (std::is_same_v<S, float> ? S(3e-6) : S(1e-13)));
      CHECK(testing::jacobian_error(
                forward.J, [&](const Vec<double, 2>& p) { return exact.distort(p).m; }, m) < tolerance);
      CHECK((forward.J * back.J - Mat<S, 2, 2>::Identity()).norm() < S(tolerance));
    }
  }
}
