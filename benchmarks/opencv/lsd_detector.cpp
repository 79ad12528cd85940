// The library's own detector and OpenCV's LSD, on one thread, on the same image.
#include "plumbline/opencv/lsd_detector.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

#include "../tracking/boxes.hpp"

namespace plumbline {
namespace {

using namespace benchmarks;

/// `needs_edges`: the map is made for the detector; an estimator has it for its tracker in any case.
template <class Detector, bool needs_edges>
void detect_lines_752x480(benchmark::State& state) {
  cv::setNumThreads(1);
  const std::vector<std::uint8_t> pixels = boxes(0, 0, 1);
  const auto edges = std::make_unique<EdgeMap<boxes_width * boxes_height>>();
  const auto detector = std::make_unique<Detector>();
  FixedVector<LineSegment, 200> segments;
  for (auto _ : state) {
    if (needs_edges) edges->compute(view_of(pixels), LineDetectorOptions{}.min_gradient);
    detector->detect(view_of(pixels), *edges, LineDetectorOptions{}, segments);
    benchmark::DoNotOptimize(segments.data());
  }
  state.counters["segments"] = static_cast<double>(segments.size());
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(detect_lines_752x480<LineSegmentDetector<>, true>)->Unit(benchmark::kMillisecond);
BENCHMARK(detect_lines_752x480<opencv::LsdDetector<>, false>)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
