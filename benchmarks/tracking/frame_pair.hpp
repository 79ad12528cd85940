#pragma once
// Two frames of one textured plane for the tracking benchmarks: the second is moved by a few pixels.

#include <cmath>
#include <cstdint>
#include <vector>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/tracking/corner_detector.hpp"

namespace plumbline::benchmarks {

constexpr int width = 640, height = 480;
using Pyr = Pyramid<4, width * height>;
using Corners = FixedVector<Corner, 150>;

struct FramePair {
  static constexpr float dx = 3.3f, dy = -2.1f;  // motion [px]

  FramePair() : first(render(0, 0)), second(render(dx, dy)) {
    previous.build(view(first));
    current.build(view(second));
    CornerOptions options;
    options.border_px = 24;
    detect_corners(previous.level(0), nullptr, 0, options, corners);
  }

  static ImageView<const std::uint8_t> view(const std::vector<std::uint8_t>& pixels) {
    return {pixels.data(), width, height, width};
  }

  /// Waves of several lengths and directions: texture on all levels.
  static std::vector<std::uint8_t> render(float shift_x, float shift_y) {
    std::vector<std::uint8_t> pixels(width * height);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const float u = float(x) - shift_x, v = float(y) - shift_y;
        const float value = 128 + 35 * std::sin(0.31f * u + 0.1f * v) * std::cos(0.23f * v - 0.05f * u) +
                            35 * std::sin(0.071f * u - 0.09f * v) * std::sin(0.083f * u + 0.043f * v) +
                            30 * std::cos(0.53f * u + 0.37f * v) * std::sin(0.011f * u * v / 40);
        pixels[std::size_t(y * width + x)] = static_cast<std::uint8_t>(value);
      }
    }
    return pixels;
  }

  std::vector<std::uint8_t> first, second;
  Pyr previous, current;
  Corners corners;
};

inline const FramePair& frame_pair() {
  static const FramePair pair;
  return pair;
}

}  // namespace plumbline::benchmarks
