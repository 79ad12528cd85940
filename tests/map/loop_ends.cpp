#include "plumbline/map/loop_ends.hpp"

#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

using Pairs = std::vector<std::array<int, 2>>;

template <int MaxNodes, int MaxLoops>
auto find(int nodes, const Pairs& loops) {
  auto ends = std::make_unique<LoopEnds<MaxNodes, MaxLoops>>();
  ends->find(nodes, int(loops.size()), [&](int l) { return loops[std::size_t(l)]; });
  return ends;
}

}  // namespace

TEST_CASE("loop_ends: which nodes they are") {
  const auto none = find<10, 4>(10, {});
  REQUIRE(none->count() == 1);
  REQUIRE(none->position(9) == 0);
  for (int k = 0; k < 9; ++k) REQUIRE(!none->is_end(k));

  const auto ends = find<10, 4>(8, {{0, 5}, {2, 5}, {3, 2}});
  REQUIRE(ends->count() == 4);  // 2, 3, 5 and the newest; the first node is fixed
  for (const int k : {2, 3, 5, 7}) REQUIRE(ends->is_end(k));
  for (const int k : {0, 1, 4, 6}) REQUIRE(!ends->is_end(k));
  REQUIRE(ends->position(7) == 3);
}

TEST_CASE("loop_ends: the pattern is that of the factor, for random loops") {
  Random random(5);
  for (int turn = 0; turn < 200; ++turn) {
    const int nodes = 2 + int(random.below(39)), count = int(random.below(13));
    Pairs loops;
    for (int l = 0; l < count; ++l) {
      const int i = int(random.below(std::uint32_t(nodes))), j = int(random.below(std::uint32_t(nodes)));
      if (i != j) loops.push_back({i, j});
    }
    const auto ends = find<40, 12>(nodes, loops);
    const int n = ends->count();
    REQUIRE(ends->position(nodes - 1) == n - 1);
    // Adjacency in the order of elimination, then elimination itself.
    std::vector<std::vector<bool>> full(std::size_t(n), std::vector<bool>(std::size_t(n), false));
    const auto connect = [&](int a, int b) {
      if (a >= 0 && b >= 0 && a != b) full[std::size_t(std::max(a, b))][std::size_t(std::min(a, b))] = true;
    };
    int before = -1;
    std::vector<bool> seen(std::size_t(n), false);
    for (int k = 1; k < nodes; ++k) {
      if (!ends->is_end(k)) continue;
      REQUIRE(!seen[std::size_t(ends->position(k))]);
      seen[std::size_t(ends->position(k))] = true;
      connect(before, ends->position(k));
      before = ends->position(k);
    }
    for (const auto& loop : loops) connect(ends->position(loop[0]), ends->position(loop[1]));
    for (int k = 0; k < n; ++k) {
      for (int p = k + 1; p < n; ++p) {
        for (int q = k + 1; q < p; ++q) {
          if (full[std::size_t(p)][std::size_t(k)] && full[std::size_t(q)][std::size_t(k)]) connect(p, q);
        }
      }
    }
    for (int p = 0; p < n; ++p) {
      for (int q = 0; q < p; ++q) REQUIRE(ends->has_block(p, q) == full[std::size_t(p)][std::size_t(q)]);
    }
  }
}

TEST_CASE("loop_ends: loops between two laps fill little") {
  Pairs loops;
  for (int l = 0; l < 20; ++l) loops.push_back({10 + 10 * l, 260 + 10 * l});
  const auto ends = find<500, 20>(500, loops);
  int blocks = 0;
  for (int p = 0; p < ends->count(); ++p) {
    for (int q = 0; q < p; ++q) blocks += ends->has_block(p, q) ? 1 : 0;
  }
  REQUIRE(ends->count() == 41);
  REQUIRE(blocks < 4 * 41);
}
