#include "plumbline/camera/omni.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("omni: camera suite", "", float, double) {
  SECTION("catadioptric, xi above 1") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Omni<S>{S(1040), S(1038), S(376), S(240), S(1.8), {S(-0.11), S(0.25), S(3e-4), S(-2e-4)}};
    };
    testing::check_camera<TestType>(make, 752, 480, 376, 240);
  }
  SECTION("xi below 1") {
    const auto make = [](auto s) {
      using S = decltype(s);
      return Omni<S>{S(500), S(501), S(320), S(240), S(0.9), {S(-0.2), S(0.05), S(1e-4), S(2e-4)}};
    };
    testing::check_camera<TestType>(make, 640, 480, 320, 240);
  }
}

TEMPLATE_TEST_CASE("omni: xi = 0 is the pinhole with the same distortion", "", float, double) {
  using S = TestType;
  const RadTan<S> lens(S(-0.28), S(0.07), S(2e-4), S(1e-4));
  const Omni<S> omni{S(500), S(510), S(320), S(240), 0, lens};
  const Pinhole<S, RadTan> pinhole{S(500), S(510), S(320), S(240), lens};
  for (S x = S(-0.5); x <= S(0.5); x += S(0.1)) {
    const auto a = omni.project({x, S(0.3), S(1.1)}), b = pinhole.project({x, S(0.3), S(1.1)});
    REQUIRE((a.valid && b.valid));
    CHECK((a.uv - b.uv).norm() < S(1e-3));
    CHECK((a.J_uv_p - b.J_uv_p).norm() < S(1e-3));
  }
  CHECK(!omni.project({1, -2, S(-0.01)}).valid);
}

TEMPLATE_TEST_CASE("omni: border of the domain", "", float, double) {
  using S = TestType;
  for (const double xi : {0.8, 1.7}) {  // seen up to z = -w |p|
    const Omni<S, NoDistortion> camera{S(100), S(100), 0, 0, S(xi)};
    const double border = std::acos(-(xi <= 1 ? xi : 1 / xi));
    const auto at = [&](double theta) {
      return camera.project(Vec<double, 3>(std::sin(theta), 0, std::cos(theta)).cast<S>()).valid;
    };
    CHECK(at(border - 0.01));
    CHECK(!at(border + 0.01));
  }
  const double q_max = 1 / (1.7 * 1.7 - 1);
  const Omni<S, NoDistortion> camera{S(100), S(100), 0, 0, S(1.7)};
  CHECK(camera.unproject({S(99.9 * std::sqrt(q_max)), 0}).valid);
  CHECK(!camera.unproject({S(100.1 * std::sqrt(q_max)), 0}).valid);
}
