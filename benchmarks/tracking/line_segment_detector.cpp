#include "plumbline/tracking/line_segment_detector.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "boxes.hpp"

namespace plumbline {
namespace {

void detect_lines_752x480(benchmark::State& state) {
  using namespace benchmarks;
  const std::vector<std::uint8_t> pixels = boxes(0, 0, 1);
  const auto edges = std::make_unique<EdgeMap<boxes_width * boxes_height>>();
  const auto detector = std::make_unique<LineSegmentDetector<>>();
  FixedVector<LineSegment, 200> segments;
  for (auto _ : state) {
    edges->compute(view_of(pixels), LineDetectorOptions{}.min_gradient);
    detector->detect(*edges, LineDetectorOptions{}, segments);
    benchmark::DoNotOptimize(segments.data());
  }
  state.counters["segments"] = static_cast<double>(segments.size());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(detect_lines_752x480)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
