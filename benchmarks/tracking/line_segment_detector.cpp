#include "plumbline/tracking/line_segment_detector.hpp"

#include <cmath>
#include <cstdint>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

namespace plumbline {
namespace {

constexpr int width = 752, height = 480;

/// Overlapping boxes of many sizes and directions with noise: about as many edges as a machine hall.
std::vector<std::uint8_t> boxes() {
  std::vector<float> sum(width * height, 90.0f);
  std::uint32_t state = 7;
  const auto uniform = [&] { return static_cast<float>((state = state * 1664525u + 1013904223u) >> 8) / 16777216.0f; };
  for (int k = 0; k < 90; ++k) {
    const float cx = uniform() * width, cy = uniform() * height, angle = uniform() * 3.14f;
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
  std::vector<std::uint8_t> pixels(sum.size());
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const float noise = 3 * (uniform() + uniform() + uniform() + uniform() - 2);
    pixels[i] = static_cast<std::uint8_t>(std::clamp(sum[i] + noise, 0.0f, 255.0f));
  }
  return pixels;
}

void detect_lines_752x480(benchmark::State& state) {
  const std::vector<std::uint8_t> pixels = boxes();
  const auto detector = std::make_unique<LineSegmentDetector<width * height>>();
  FixedVector<LineSegment, 200> segments;
  for (auto _ : state) {
    detector->detect({pixels.data(), width, height, width}, LineDetectorOptions{}, segments);
    benchmark::DoNotOptimize(segments.data());
  }
  state.counters["segments"] = static_cast<double>(segments.size());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(detect_lines_752x480)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
