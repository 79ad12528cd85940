#include "plumbline/camera/pinhole.hpp"

#include "camera_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("pinhole: camera suite", "", float, double) {
  const auto make = [](auto s) {
    using S = decltype(s);
    return Pinhole<S>{S(458.654), S(457.296), S(367.215), S(248.375)};
  };
  testing::check_camera<TestType>(make, 752, 480, 367.215, 248.375);
}

TEMPLATE_TEST_CASE("pinhole: border of the domain", "", float, double) {
  using S = TestType;
  const Pinhole<S> camera{500, 500, 320, 240};
  CHECK(camera.project({0, 0, S(2) * Pinhole<S>::z_min}).valid);
  CHECK(!camera.project({0, 0, Pinhole<S>::z_min}).valid);
  CHECK(!camera.project({1, 1, -1}).valid);
  const Projection<S> pixel = camera.project({1, -2, 4});
  CHECK(pixel.uv.x() == S(445));
  CHECK(pixel.uv.y() == S(-10));
}
