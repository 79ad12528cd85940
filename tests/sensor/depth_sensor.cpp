#include "plumbline/sensor/depth_sensor.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// A depth image around pixel (size/2, size/2).
template <int size>
struct Square {
  std::array<std::uint16_t, size * size> raw;
  explicit Square(std::uint16_t value) { raw.fill(value); }
  std::uint16_t& at(int x, int y) { return raw[static_cast<std::size_t>(y * size + x)]; }
  ImageView<const std::uint16_t> view() const { return {raw.data(), size, size, size}; }
};
using Patch = Square<5>;

}  // namespace

TEMPLATE_TEST_CASE("depth_sensor: a flat surface", "", float, double) {
  const DepthSensor<TestType> sensor;
  const InverseDepth<TestType> depth = sensor.at(Patch(2000).view(), {2.2f, 1.9f});
  REQUIRE(depth.valid);
  REQUIRE(depth.value == Approx(0.5));
  const double near = sensor.k0 * 0.25;
  REQUIRE(depth.sigma == Approx(std::sqrt(sensor.k * sensor.k + near * near)));
}

TEST_CASE("depth_sensor: outliers, holes and edges") {
  const DepthSensor<double> sensor;
  Patch noisy(2000);
  noisy.at(1, 1) = 2020;
  noisy.at(2, 2) = 1985;
  REQUIRE(sensor.at(noisy.view(), {2, 2}).value == Approx(0.5));

  Patch holes(0);
  for (int x = 1; x <= 3; ++x) holes.at(x, 1) = 2000;
  REQUIRE_FALSE(sensor.at(holes.view(), {2, 2}).valid);  // three of nine
  holes.at(1, 2) = holes.at(2, 2) = 2000;
  REQUIRE(sensor.at(holes.view(), {2, 2}).valid);

  Patch edge(2000);
  for (int y = 0; y < 5; ++y) edge.at(3, y) = 3000;
  REQUIRE_FALSE(sensor.at(edge.view(), {2, 2}).valid);
}

TEST_CASE("depth_sensor: a corner beside a nearer surface belongs to it") {
  const DepthSensor<double> sensor;
  const auto at_center = [&](const Square<9>& image) { return sensor.at(image.view(), {4, 4}); };
  const double background = 0.4, foreground = 0.5;  // 2.5 m and 2 m, with a slope of 0.002 1/m a pixel
  const auto surface = [](double inverse_depth) { return std::uint16_t(std::lround(1000 / inverse_depth)); };
  for (int first = 2; first <= 8; ++first) {  // the nearer surface begins there, behind it is the other one
    Square<9> image(0);
    for (int y = 0; y < 9; ++y) {
      for (int x = 0; x < 9; ++x) image.at(x, y) = surface((x >= first ? foreground : background) + 0.002 * y);
    }
    CAPTURE(first);
    const InverseDepth<double> depth = at_center(image);
    if (!depth.valid) continue;  // an edge in between
    REQUIRE(depth.value == Approx((first <= 7 ? foreground : background) + 0.008).margin(5e-4));
  }
  Square<9> image(0), corner(0), far_corner(0), noisy(0);
  for (int y = 0; y < 9; ++y) {
    for (int x = 0; x < 9; ++x) {
      image.at(x, y) = surface(background + 0.01 * x - 0.004 * y);              // a plane, aslant
      corner.at(x, y) = surface(x >= 3 && y >= 3 ? foreground : background);    // its own
      far_corner.at(x, y) = surface(x < 3 || y < 3 ? foreground : background);  // two surfaces before it
      noisy.at(x, y) = surface(background + ((x + y) % 4 == 3 ? 0.006 : x == 1 ? -0.006 : 0));
    }
  }
  REQUIRE(at_center(image).value == Approx(background + 0.04 - 0.016).margin(5e-4));
  REQUIRE(at_center(corner).value == Approx(foreground).margin(5e-4));
  REQUIRE(at_center(far_corner).value == Approx(foreground).margin(5e-4));
  REQUIRE(at_center(noisy).value == Approx(background).margin(5e-4));
  for (int i = 0; i < 9; ++i) image.at(i, 1) = image.at(7, i) = 0;  // holes
  REQUIRE(at_center(image).value == Approx(background + 0.04 - 0.016).margin(5e-4));
}

TEST_CASE("depth_sensor: out of range, out of the image, not a number") {
  const DepthSensor<double> sensor;
  REQUIRE_FALSE(sensor.at(Patch(100).view(), {2, 2}).valid);
  REQUIRE_FALSE(sensor.at(Patch(60000).view(), {2, 2}).valid);
  REQUIRE_FALSE(sensor.at(Patch(2000).view(), {0, 2}).valid);
  REQUIRE_FALSE(sensor.at(Patch(2000).view(), {std::numeric_limits<float>::quiet_NaN(), 2}).valid);
  REQUIRE_FALSE(sensor.at({}, {2, 2}).valid);
}
