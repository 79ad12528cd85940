#include "plumbline/tracking/line_tracking.hpp"

#include <cstdint>
#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

#include "boxes.hpp"
#include "plumbline/tracking/line_segment_detector.hpp"

namespace plumbline {
namespace {

using namespace benchmarks;
using Edges = EdgeMap<boxes_width * boxes_height>;

void compute_edge_map_752x480(benchmark::State& state) {
  const std::vector<std::uint8_t> pixels = boxes(0, 0, 1);
  const auto edges = std::make_unique<Edges>();
  for (auto _ : state) benchmark::DoNotOptimize(edges->compute(view_of(pixels), 1.6f));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(compute_edge_map_752x480)->Unit(benchmark::kMicrosecond);

/// Segments moved by 5 px, guessed at their old places; the edge map is there already.
void track_60_lines(benchmark::State& state) {
  const std::vector<std::uint8_t> before = boxes(0, 0, 1), after = boxes(4, -3, 2);
  const auto edges = std::make_unique<Edges>();
  const auto detector = std::make_unique<LineSegmentDetector<>>();
  FixedVector<LineSegment, 60> segments;
  edges->compute(view_of(before), 1.6f);
  detector->detect(*edges, LineDetectorOptions{}, segments);
  std::vector<LineProfile> profiles;
  for (const LineSegment& segment : segments) profiles.push_back(profile_of(view_of(before), segment));
  edges->compute(view_of(after), 1.6f);
  LineTracker tracker;
  int valid = 0;
  for (auto _ : state) {
    valid = 0;
    for (std::size_t i = 0; i < segments.size(); ++i) {
      valid += tracker.track(*edges, view_of(after), profiles[i], segments[i], LineTrackingOptions{}).valid;
    }
    benchmark::DoNotOptimize(valid);
  }
  state.counters["valid"] = valid;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(segments.size()));
}
BENCHMARK(track_60_lines)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
