#include "plumbline/tracking/corner_detector.hpp"

#include <vector>

#include <benchmark/benchmark.h>

#include "frame_pair.hpp"

namespace plumbline {
namespace {

/// With so many features already there, spread over the image.
void detect_corners_640x480(benchmark::State& state) {
  const benchmarks::FramePair& pair = benchmarks::frame_pair();
  std::vector<Vec<float, 2>> existing;
  for (int i = 0; i < state.range(0); ++i) existing.push_back(pair.corners[std::size_t(i)].uv);
  for (auto _ : state) {
    benchmarks::Corners corners;
    detect_corners(pair.previous.level(0), existing.data(), existing.size(), CornerOptions{}, corners);
    benchmark::DoNotOptimize(corners.data());
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(detect_corners_640x480)->Arg(0)->Arg(100);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
