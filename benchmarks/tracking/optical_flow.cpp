#include "plumbline/tracking/optical_flow.hpp"

#include <benchmark/benchmark.h>

#include "frame_pair.hpp"

namespace plumbline {
namespace {

/// Forth and back for 150 points, guessed at their old places.
template <int PatchSize>
void track_150_points_checked(benchmark::State& state) {
  const benchmarks::FramePair& pair = benchmarks::frame_pair();
  int valid = 0;
  for (auto _ : state) {
    valid = 0;
    for (const Corner& corner : pair.corners) {
      valid +=
          track_point_checked<PatchSize>(pair.previous, pair.current, corner.uv, corner.uv, OpticalFlowOptions{}).valid;
    }
    benchmark::DoNotOptimize(valid);
  }
  state.counters["valid"] = valid;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(pair.corners.size()));
}
BENCHMARK(track_150_points_checked<8>);
BENCHMARK(track_150_points_checked<12>);
BENCHMARK(track_150_points_checked<16>);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
