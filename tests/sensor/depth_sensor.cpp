#include "plumbline/sensor/depth_sensor.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

namespace {

/// A depth image around pixel (2, 2).
struct Patch {
  static constexpr int size = 5;
  std::array<std::uint16_t, size * size> raw;
  explicit Patch(std::uint16_t value) { raw.fill(value); }
  std::uint16_t& at(int x, int y) { return raw[static_cast<std::size_t>(y * size + x)]; }
  ImageView<const std::uint16_t> view() const { return {raw.data(), size, size, size}; }
};

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

TEST_CASE("depth_sensor: the depth is that of the surface measured at the pixel, on any slope") {
  const DepthSensor<double> sensor;
  const auto surface = [](double inverse_depth) { return std::uint16_t(std::lround(1000 / inverse_depth)); };
  Patch plane(0), near_edge(0);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 5; ++x) {
      plane.at(x, y) = surface(0.4 + 0.01 * x - 0.004 * y);
      near_edge.at(x, y) = surface(x == 4 ? 0.5 : 0.4);  // a nearer surface begins two pixels away
    }
  }
  REQUIRE(sensor.at(plane.view(), {2, 2}).value == Approx(0.4 + 0.02 - 0.008).margin(5e-4));
  REQUIRE(sensor.at(near_edge.view(), {2, 2}).value == Approx(0.4).margin(5e-4));
}

TEST_CASE("depth_sensor: out of range, out of the image, not a number") {
  const DepthSensor<double> sensor;
  REQUIRE_FALSE(sensor.at(Patch(100).view(), {2, 2}).valid);
  REQUIRE_FALSE(sensor.at(Patch(60000).view(), {2, 2}).valid);
  REQUIRE_FALSE(sensor.at(Patch(2000).view(), {0, 2}).valid);
  REQUIRE_FALSE(sensor.at(Patch(2000).view(), {std::numeric_limits<float>::quiet_NaN(), 2}).valid);
  REQUIRE_FALSE(sensor.at({}, {2, 2}).valid);
}
