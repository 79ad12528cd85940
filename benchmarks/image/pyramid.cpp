#include "plumbline/image/pyramid.hpp"

#include <memory>
#include <vector>

#include <benchmark/benchmark.h>

namespace plumbline {
namespace {

void pyramid_build_640x480(benchmark::State& state) {
  std::vector<std::uint8_t> pixels(640 * 480);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<std::uint8_t>(i * i >> 7);
  const auto pyramid = std::make_unique<Pyramid<4, 640 * 480>>();
  for (auto _ : state) benchmark::DoNotOptimize(pyramid->build({pixels.data(), 640, 480, 640}));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(pyramid_build_640x480);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
