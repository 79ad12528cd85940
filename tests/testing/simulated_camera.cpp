#include "plumbline/testing/simulated_camera.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;
using namespace plumbline::testing;

namespace {

constexpr int width = 160, height = 120;
const Pinhole<double> pinhole{135, 135, 79.5, 59.5};
const Trajectory room_path = *Trajectory::for_scene("room");

SimulatedCamera make_camera(const CameraEffects& effects, std::uint64_t seed) {
  static const Renderer baked(*make_scene("room"), pinhole, width, height, 4);
  return {baked, simulated_T_body_camera(), effects, seed};
}

}  // namespace

TEST_CASE("simulated_camera: same seed, same bytes, in any order of the frames") {
  SimulatedCamera a = make_camera({}, 3), b = make_camera({}, 3), c = make_camera({}, 4);
  const SimulatedCamera::Frame first = a.frame(room_path, 3, 0), second = a.frame(room_path, 3.05, 1);
  const SimulatedCamera::Frame again = b.frame(room_path, 3.05, 1), other = c.frame(room_path, 3.05, 1);
  REQUIRE(second.gray.pixels() == again.gray.pixels());
  REQUIRE(second.depth.pixels() == again.depth.pixels());
  REQUIRE(second.gray.pixels() != other.gray.pixels());
  REQUIRE(second.gray.pixels() != first.gray.pixels());
}

TEST_CASE("simulated_camera: noise has its sigma, and depth noise grows with the square") {
  CameraEffects clean;
  clean.noise_sigma = 0;
  clean.depth_sigma = 0;
  clean.edge_dropout = 0;
  CameraEffects noisy = clean;
  noisy.noise_sigma = 2;
  noisy.depth_sigma = 5e-3;
  const SimulatedCamera::Frame exact = make_camera(clean, 1).frame(room_path, 4, 7);
  const SimulatedCamera::Frame measured = make_camera(noisy, 1).frame(room_path, 4, 7);
  double gray2 = 0, depth2 = 0;
  for (std::size_t i = 0; i < exact.gray.pixels().size(); ++i) {
    gray2 += std::pow(measured.gray.pixels()[i] - exact.gray.pixels()[i], 2);
    REQUIRE(exact.depth.pixels()[i] > 0);
    const double z = exact.depth.pixels()[i] / 1000.0;
    depth2 += std::pow((measured.depth.pixels()[i] / 1000.0 - z) / (z * z), 2);
  }
  REQUIRE(std::sqrt(gray2 / (width * height)) == Approx(2).epsilon(0.04));
  REQUIRE(std::sqrt(depth2 / (width * height)) == Approx(5e-3).epsilon(0.03));
}

TEST_CASE("simulated_camera: depth has holes off its range and at edges only") {
  CameraEffects effects;
  effects.depth_sigma = 0;
  effects.edge_dropout = 1;
  effects.depth_max = 2.2;
  SimulatedCamera camera = make_camera(effects, 1);
  const SimulatedCamera::Frame frame = camera.frame(room_path, 4, 0);
  Image<float> gray(width, height), z(width, height);
  camera.renderer().render(room_path.at(4).T_world_body * simulated_T_body_camera(), gray.view(), z.view());
  int far_holes = 0, edge_holes = 0;
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      const float c = z.view()(x, y);
      float step = 0;
      for (const auto& [dx, dy] : {std::pair{1, 0}, {-1, 0}, {0, 1}, {0, -1}}) {
        step = std::max(step, std::abs(z.view()(x + dx, y + dy) - c));
      }
      const bool hole = frame.depth.view()(x, y) == 0;
      if (c > 2.2f) {
        REQUIRE(hole);
        ++far_holes;
      } else if (step > 0.04f * c) {
        REQUIRE(hole);
        ++edge_holes;
      } else if (step < 0.019f * c) {
        REQUIRE(!hole);
      }
    }
  }
  REQUIRE(far_holes > 100);
  REQUIRE(edge_holes > 20);
}

TEST_CASE("simulated_camera: exposure changes and motion blur have the stated effect") {
  const auto mean = [](const SimulatedCamera::Frame& f) {
    double sum = 0;
    for (const std::uint8_t p : f.gray.pixels()) sum += p;
    return sum / (width * height);
  };
  const auto sharpness = [](SimulatedCamera::Frame& f) {
    double sum = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 1; x < width; ++x) sum += std::abs(f.gray.view()(x, y) - f.gray.view()(x - 1, y));
    }
    return sum;
  };
  CameraEffects still, brighter, blurred;
  still.noise_sigma = brighter.noise_sigma = blurred.noise_sigma = 0;
  brighter.exposure_amplitude = 0.2;
  blurred.exposure_time_s = 0.06;
  SimulatedCamera::Frame plain = make_camera(still, 1).frame(room_path, 7.5, 0);  // a quarter period of exposure
  SimulatedCamera::Frame bright = make_camera(brighter, 1).frame(room_path, 7.5, 0);
  SimulatedCamera::Frame smeared = make_camera(blurred, 1).frame(room_path, 7.5, 0);
  REQUIRE(mean(bright) / mean(plain) == Approx(1.2).epsilon(0.03));
  REQUIRE(mean(smeared) == Approx(mean(plain)).epsilon(0.03));
  REQUIRE(sharpness(smeared) < 0.9 * sharpness(plain));
  REQUIRE(smeared.depth.pixels() == plain.depth.pixels());
}

TEST_CASE("simulated_camera: a rolling shutter exposes the middle row at the stamp, the others before and after") {
  CameraEffects clean, rolling;
  clean.noise_sigma = rolling.noise_sigma = clean.edge_dropout = rolling.edge_dropout = 0;
  clean.depth_sigma = rolling.depth_sigma = 0;
  rolling.readout_s = 0.04;
  const double t = 7.5, half = 0.02;
  const SimulatedCamera::Frame rolled = make_camera(rolling, 1).frame(room_path, t, 0);
  const auto differing = [&](double at, int row) {  // pixels of that row that a global shutter would have otherwise
    const SimulatedCamera::Frame global = make_camera(clean, 1).frame(room_path, at, 0);
    int n = 0;
    for (int x = 0; x < width; ++x)
      n += std::abs(rolled.depth.view()(x, row) - global.depth.view()(x, row)) > 2;  // [mm]
    return n;
  };
  for (const auto& [row, at] : {std::pair{0, t - half}, {height / 2, t}, {height - 1, t + half}}) {
    CAPTURE(row);
    REQUIRE(differing(at, row) < width / 20);
  }
  REQUIRE(differing(t + half, 0) > width / 5);
}
