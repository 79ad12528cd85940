#include "plumbline/map/place_index.hpp"

#include <benchmark/benchmark.h>

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "plumbline/core/random.hpp"
#include "plumbline/map/hamming_place_index.hpp"

namespace plumbline {
namespace {

constexpr std::size_t keyframes = 500, descriptors = 300;
using Index = HammingPlaceIndex<keyframes, descriptors>;
using Places = std::vector<std::vector<BinaryDescriptor>>;

/// 50 places, each seen ten times; a 32nd of the bits of every descriptor is turned at random.
Places simulated_places() {
  Random random(3);
  Places landmarks(50), out;
  for (auto& place : landmarks) {
    place.resize(descriptors);
    for (BinaryDescriptor& d : place) {
      for (auto& word : d.words) word = random.next();
    }
  }
  for (std::size_t i = 0; i < keyframes; ++i) {
    out.push_back(landmarks[i % landmarks.size()]);
    for (BinaryDescriptor& d : out.back()) {
      for (auto& word : d.words) word ^= random.next() & random.next() & random.next() & random.next() & random.next();
    }
  }
  return out;
}

const Places& places() {
  static const Places all = simulated_places();
  return all;
}

std::unique_ptr<Index> full_index() {
  auto index = std::make_unique<Index>();
  for (std::uint32_t i = 0; i < keyframes; ++i) index->add(i, places()[i]);
  return index;
}

void query_500_keyframes_of_300_descriptors(benchmark::State& state) {
  const auto index = full_index();
  std::array<PlaceCandidate, 10> out;
  std::size_t i = 0, found = 0;
  for (auto _ : state) {
    found += index->query(places()[i++ % keyframes], out);
    benchmark::DoNotOptimize(out);
  }
  state.counters["candidates"] = benchmark::Counter(double(found), benchmark::Counter::kAvgIterations);
  state.counters["MiB"] = double(sizeof(Index)) / (1 << 20);
}
BENCHMARK(query_500_keyframes_of_300_descriptors)->Unit(benchmark::kMillisecond);

/// The oldest keyframe goes and a new one comes.
void replace_keyframe(benchmark::State& state) {
  const auto index = full_index();
  std::uint32_t id = 0;
  for (auto _ : state) {
    index->remove(id);
    benchmark::DoNotOptimize(index->add(id, places()[id]));
    id = (id + 1) % keyframes;
  }
}
BENCHMARK(replace_keyframe)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace plumbline

BENCHMARK_MAIN();
