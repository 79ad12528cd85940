#include "plumbline/camera/equidistant.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("equidistant: camera suite", "", float, double) {
  SECTION("TUM VI cam0, 195 degrees across") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Equidistant<S>(S(190.978477), S(190.973307), S(254.931706), S(256.897442), S(0.00348239), S(0.000715035),
                            S(-0.00205324), S(0.000202937));
    };
    testing::check_camera<TestType>(make, 512, 512, 254.931706, 256.897442);
  }
  SECTION("ideal lens up to 160 degrees from the axis") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Equidistant<S>(100, 100, 300, 300);
    };
    testing::check_camera<TestType>(make, 600, 600, 300, 300, 280);
  }
}

TEMPLATE_TEST_CASE("equidistant: the ideal lens maps angles to radii", "", float, double) {
  using S = TestType;
  const Equidistant<S> camera(200, 200, 0, 0);
  for (const double theta : {1e-9, 1e-4, 0.3, 1.5, 1.5707963267948966, 2.0, 3.0}) {
    const Projection<S> pixel = camera.project(Vec<double, 3>(std::sin(theta), 0, std::cos(theta)).cast<S>());
    REQUIRE(pixel.valid);
    CHECK(double(pixel.uv.x()) == Approx(200 * theta).epsilon(1e-5));
  }
}

TEMPLATE_TEST_CASE("equidistant: rejects beyond the turning point", "", float, double) {
  using S = TestType;
  const Equidistant<S> camera(200, 200, 0, 0,
                              S(-0.2));  // th (1 - 0.2 th^2) turns back at th = 1/sqrt(0.6), where it is 0.8607
  CHECK(double(camera.theta_max()) == Approx(1.2909944487358056).epsilon(1e-6));
  CHECK(camera.project(Vec<double, 3>(std::sin(1.28), 0, std::cos(1.28)).cast<S>()).valid);
  CHECK(!camera.project(Vec<double, 3>(std::sin(1.30), 0, std::cos(1.30)).cast<S>()).valid);
  CHECK(camera.unproject({S(200 * 0.860), 0}).valid);
  CHECK(!camera.unproject({S(200 * 0.861), 0}).valid);
  CHECK(!camera.unproject({S(0), S(-500)}).valid);
}
