#include "plumbline/core/counting_sort.hpp"

#include <algorithm>
#include <array>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

TEST_CASE("counting_sort: a stable sort, and where each key begins") {
  Random random(1);
  for (const int items : {0, 1, 7, 500}) {
    for (const int keys : {1, 3, 50}) {
      std::vector<int> key_of(static_cast<std::size_t>(items)), expected(key_of.size()), found(key_of.size());
      for (int n = 0; n < items; ++n) {
        key_of[std::size_t(n)] = int(random.below(std::uint64_t(keys)));
        expected[std::size_t(n)] = n;
      }
      const auto key = [&](int n) { return key_of[std::size_t(n)]; };
      std::stable_sort(expected.begin(), expected.end(), [&](int a, int b) { return key(a) < key(b); });
      std::array<int, 51> begin;
      counting_sort(
          items, keys, begin, key, [](int n) { return n; }, found);
      CHECK(found == expected);
      CHECK(begin[std::size_t(keys)] == items);
      for (int k = 0; k < keys; ++k) {
        for (int n = begin[std::size_t(k)]; n < begin[std::size_t(k) + 1]; ++n) {
          REQUIRE(key(found[std::size_t(n)]) == k);
        }
      }
    }
  }
}
