#include "plumbline/camera/double_sphere.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("double_sphere: camera suite", "", float, double) {
  SECTION("fisheye of 195 degrees") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return DoubleSphere<S>(S(156.9), S(156.8), S(254.9), S(256.9), S(-0.1792), S(0.5912));
    };
    testing::check_camera<TestType>(make, 512, 512, 254.9, 256.9, 340);
  }
  SECTION("alpha below one half") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return DoubleSphere<S>(S(300), S(310), S(320), S(240), S(0.1), S(0.4));
    };
    testing::check_camera<TestType>(make, 640, 480, 320, 240);
  }
}

TEMPLATE_TEST_CASE("double_sphere: xi = alpha = 0 is the pinhole", "", float, double) {
  using S = TestType;
  const DoubleSphere<S> camera(500, 400, 320, 240, 0, 0);
  const Projection<S> pixel = camera.project({1, -2, 4});
  REQUIRE(pixel.valid);
  CHECK(double(pixel.uv.x()) == Approx(445));
  CHECK(double(pixel.uv.y()) == Approx(40));
  CHECK(!camera.project({1, -2, S(-0.01)}).valid);
}

TEMPLATE_TEST_CASE("double_sphere: border of the domain", "", float, double) {
  using S = TestType;
  const DoubleSphere<S> camera(100, 100, 0, 0, S(-0.2), S(0.6));
  const double q_max = 1 / (2 * 0.6 - 1);
  CHECK(camera.unproject({S(99.9 * std::sqrt(q_max)), 0}).valid);
  CHECK(!camera.unproject({S(100.1 * std::sqrt(q_max)), 0}).valid);
  // Along a meridian the radius grows up to the border and the point is rejected behind it.
  S previous = 0;
  bool inside = true;
  for (double theta = 0.01; theta < 3.14; theta += 0.01) {
    const Projection<S> pixel = camera.project(Vec<double, 3>(std::sin(theta), 0, std::cos(theta)).cast<S>());
    CHECK((inside || !pixel.valid));
    inside = pixel.valid;
    if (inside) CHECK(pixel.uv.x() > previous);
    if (inside) previous = pixel.uv.x();
  }
  CHECK(!inside);
  CHECK(previous > S(98) * S(std::sqrt(q_max)));
}
