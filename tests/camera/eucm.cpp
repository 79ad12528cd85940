#include "plumbline/camera/eucm.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("eucm: camera suite", "", float, double) {
  SECTION("fisheye") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Eucm<S>(S(190.2), S(190.1), S(254.9), S(256.9), S(0.63), S(1.04));
    };
    testing::check_camera<TestType>(make, 512, 512, 254.9, 256.9, 330);
  }
  SECTION("alpha below one half") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Eucm<S>(S(300), S(310), S(320), S(240), S(0.4), S(1.2));
    };
    testing::check_camera<TestType>(make, 640, 480, 320, 240);
  }
}

TEMPLATE_TEST_CASE("eucm: alpha = 0 is the pinhole", "", float, double) {
  using S = TestType;
  const Eucm<S> camera(500, 400, 320, 240, 0, 1);
  const Projection<S> pixel = camera.project({1, -2, 4});
  REQUIRE(pixel.valid);
  CHECK(double(pixel.uv.x()) == Approx(445));
  CHECK(double(pixel.uv.y()) == Approx(40));
  CHECK(!camera.project({1, -2, S(-0.01)}).valid);
}

TEMPLATE_TEST_CASE("eucm: border of the domain", "", float, double) {
  using S = TestType;
  const Eucm<S> camera(100, 100, 0, 0, S(0.6), S(1.1));
  const double r_max = std::sqrt(1 / (1.1 * (2 * 0.6 - 1)));
  CHECK(camera.unproject({S(99.9 * r_max), 0}).valid);
  CHECK(!camera.unproject({S(100.1 * r_max), 0}).valid);
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
  CHECK(previous > S(98) * S(r_max));
}
