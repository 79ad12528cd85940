#pragma once
// Straight edges for the line benchmarks.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "plumbline/image/image_view.hpp"

namespace plumbline::benchmarks {

constexpr int boxes_width = 752, boxes_height = 480;

/// Overlapping boxes of many sizes and directions moved by a shift, with noise: about as many edges as a machine hall.
inline std::vector<std::uint8_t> boxes(float shift_x, float shift_y, std::uint32_t noise_seed) {
  constexpr int width = boxes_width, height = boxes_height;
  std::vector<float> sum(width * height, 90.0f);
  std::uint32_t state = 7;
  const auto uniform = [&] { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) / 16777216.0f; };
  for (int k = 0; k < 90; ++k) {
    const float cx = uniform() * width + shift_x, cy = uniform() * height + shift_y, angle = uniform() * 3.14f;
    const float c = std::cos(angle), s = std::sin(angle), contrast = 80 * (uniform() - 0.5f);
    const float half_w = 10 + 80 * uniform(), half_h = 10 + 50 * uniform();
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const float dx = static_cast<float>(x) - cx, dy = static_cast<float>(y) - cy;
        const float u = half_w - std::abs(c * dx + s * dy), v = half_h - std::abs(c * dy - s * dx);
        sum[static_cast<std::size_t>(y * width + x)] += contrast * std::clamp(std::min(u, v), 0.0f, 1.0f);
      }
    }
  }
  state = noise_seed;
  std::vector<std::uint8_t> pixels(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const float noise = 3 * (uniform() + uniform() + uniform() + uniform() - 2);
    pixels[i] = static_cast<std::uint8_t>(std::clamp(sum[i] + noise, 0.0f, 255.0f));
  }
  return pixels;
}

inline ImageView<const std::uint8_t> view_of(const std::vector<std::uint8_t>& pixels) {
  return {pixels.data(), boxes_width, boxes_height, boxes_width};
}

}  // namespace plumbline::benchmarks
