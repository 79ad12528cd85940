// Points that are followed from image to image, and forgotten where an image is left out.
#include "plumbline/map/frame_tracks.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/pyramid.hpp"

using namespace plumbline;

namespace {

constexpr int width = 200, height = 160;
using Images = Pyramid<4, width * height>;

struct View {
  TimeNs t_ns;
  double dt;
  const Images &previous, &current;
  Pinhole<double> intrinsics{200, 200, 99.5, 79.5, {}};
  const Pinhole<double>& camera() const { return intrinsics; }
};

/// Squares of random brightness, moved by that many pixels to the left.
std::unique_ptr<Images> drawn(int shift_px) {
  std::vector<std::uint8_t> gray(width * height);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const std::uint32_t square = std::uint32_t((x + shift_px) / 9) * 73856093u ^ std::uint32_t(y / 9) * 19349663u;
      gray[std::size_t(y * width + x)] = std::uint8_t(30 + (square * 2654435761u >> 24) * 3 / 4);
    }
  }
  auto out = std::make_unique<Images>();
  REQUIRE(out->build(ImageView<const std::uint8_t>{gray.data(), width, height, width}));
  return out;
}

struct Run {
  std::unique_ptr<Images> a = drawn(0), b = drawn(4), c = drawn(8);
  FrameTracks<double, 20> tracks;
  int corners = 0;

  Run() {
    tracks.follow(View{100, 1e-7, *c, *a}, SO3<double>(), {});
    for (int y = 45; y < 120; y += 18) {
      for (int x = 54; x < 150; x += 27, ++corners) tracks.add({{0, 0, 1}, Vec<float, 2>(float(x), float(y)), {}});
    }
    REQUIRE(corners == 20);
    REQUIRE(tracks.size() == 20);
  }
};

}  // namespace

TEST_CASE("frame_tracks: points move with the image") {
  Run run;
  run.tracks.follow(View{200, 1e-7, *run.a, *run.b}, SO3<double>(), {});
  REQUIRE(run.tracks.size() > 12);
  for (const auto& track : run.tracks.tracks()) {
    const float from = track.pixel.x() + 4 - 54;
    CHECK(std::abs(from - 27 * std::round(from / 27)) < 0.5f);
  }
  const std::size_t before = run.tracks.size();
  run.tracks.follow(View{300, 1e-7, *run.b, *run.c}, SO3<double>(), {});
  CHECK(run.tracks.size() > before / 2);
}

TEST_CASE("frame_tracks: an image between, or another previous image, ends them") {
  Run late, other;
  late.tracks.follow(View{TimeNs(1e9), 0.03, *late.a, *late.b}, SO3<double>(), {});
  CHECK(late.tracks.size() == 0);
  other.tracks.follow(View{200, 1e-7, *other.c, *other.b}, SO3<double>(), {});
  CHECK(other.tracks.size() == 0);
}

TEST_CASE("frame_tracks: none is near another one, and only so many are kept") {
  Run run;
  run.tracks.keep_if([](std::size_t i) { return i % 2 == 0; });
  CHECK(run.tracks.size() == 10);
  const Vec<float, 2> there = run.tracks.tracks()[0].pixel;
  run.tracks.add({{0, 0, 1}, Vec<float, 2>(there.x() + 3, there.y()), {}});
  CHECK(run.tracks.size() == 10);
  run.tracks.add({{0, 0, 1}, Vec<float, 2>(there.x() + 9, there.y()), {}});
  CHECK(run.tracks.size() == 11);
  for (int k = 0; k < 30; ++k) run.tracks.add({{0, 0, 1}, Vec<float, 2>(float(1000 + 10 * k), 0), {}});
  CHECK(run.tracks.size() == 20);
  run.tracks.clear();
  CHECK(run.tracks.size() == 0);
}
