#include "plumbline/tracking/feature_alignment.hpp"

#include <vector>

#include <benchmark/benchmark.h>

#include "frame_pair.hpp"

namespace plumbline {
namespace {

/// 150 reference patches from guesses wrong by 1.5 px.
void align_150_patches(benchmark::State& state) {
  const benchmarks::FramePair& pair = benchmarks::frame_pair();
  std::vector<ReferencePatch> patches(pair.corners.size());
  for (std::size_t i = 0; i < patches.size(); ++i) patches[i].capture(pair.previous, pair.corners[i].uv);
  Mat<float, 2, 2> A;
  A << 1.0f, 0.02f, -0.02f, 1.0f;
  const Vec<float, 2> guess(benchmarks::FramePair::dx + 1.2f, benchmarks::FramePair::dy - 0.9f);
  int valid = 0;
  for (auto _ : state) {
    valid = 0;
    for (std::size_t i = 0; i < patches.size(); ++i) {
      valid += align_patch(patches[i], A, pair.current, pair.corners[i].uv + guess, AlignmentOptions{}).valid;
    }
    benchmark::DoNotOptimize(valid);
  }
  state.counters["valid"] = valid;
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(patches.size()));
}
BENCHMARK(align_150_patches);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
