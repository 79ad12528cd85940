#include "plumbline/io/association.hpp"

#include <algorithm>
#include <cstdint>
#include <random>
#include <tuple>
#include <vector>

#include "catch.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

/// What the pairs are by definition: all within the limit, the closest first, each time used once.
IndexPairs closest_first(const std::vector<TimeNs>& a, const std::vector<TimeNs>& b, TimeNs limit) {
  std::vector<std::tuple<double, std::size_t, std::size_t>> all;
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t j = 0; j < b.size(); ++j)
      if (std::abs(a[i] - b[j]) <= limit) all.emplace_back(std::abs(seconds(a[i]) - seconds(b[j])), i, j);
  std::sort(all.begin(), all.end());
  std::vector<bool> a_used(a.size()), b_used(b.size());
  IndexPairs pairs;
  for (const auto& [difference, i, j] : all) {
    if (a_used[i] || b_used[j]) continue;
    a_used[i] = b_used[j] = true;
    pairs.emplace_back(i, j);
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<TimeNs> random_times(std::mt19937& random, std::size_t n, TimeNs step) {
  std::vector<TimeNs> times{1'500'000'000'000'000'000};
  while (times.size() < n) times.push_back(times.back() + step * TimeNs(1 + random() % 20));
  return times;
}

}  // namespace

TEST_CASE("association: the nearest, within the limit") {
  REQUIRE(associate_times({0, 100, 200}, {3, 95, 300}, 10) == IndexPairs{{0, 0}, {1, 1}});
  REQUIRE(associate_times({0}, {10}, 10) == IndexPairs{{0, 0}});
  REQUIRE(associate_times({0}, {11}, 10).empty());
  REQUIRE(associate_times({}, {1, 2}, 10).empty());
}

TEST_CASE("association: each is used once, by the closest") {
  const std::vector<TimeNs> a{0, 10'000'000}, b{9'000'000};
  REQUIRE(associate_times(a, b, 20'000'000) == IndexPairs{{1, 0}});
  REQUIRE(associate_times(b, a, 20'000'000) == IndexPairs{{0, 1}});
}

TEST_CASE("association: the one that lost its partner takes the next best") {
  const std::vector<TimeNs> a{0, 10'000'000}, b{9'000'000, 15'000'000};
  REQUIRE(associate_times(a, b, 20'000'000) == IndexPairs{{0, 1}, {1, 0}});
}

TEST_CASE("association: as by definition, ties included") {
  std::mt19937 random(1);
  for (int i = 0; i < 300; ++i) {
    const auto a = random_times(random, 1 + random() % 60, 5'000'000),
               b = random_times(random, 1 + random() % 60, 5'000'000);
    for (const TimeNs limit :
         {TimeNs(0), TimeNs(5'000'000), TimeNs(22'000'000), TimeNs(1'000'000'000), TimeNs(INT64_MAX)}) {
      CAPTURE(i, limit);
      REQUIRE(associate_times(a, b, limit) == closest_first(a, b, limit));
    }
  }
}

TEST_CASE("association: a limit beyond everything costs no more") {
  std::vector<TimeNs> a, b;  // each with each would be 40 GB
  for (TimeNs i = 0; i < 50'000; ++i) {
    a.push_back(i * 10'000'000);
    b.push_back(a.back() + 3'600'000'000'000);
  }
  REQUIRE(associate_times(a, b, INT64_MAX).size() == 50'000);
}
