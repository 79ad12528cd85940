#include "plumbline/io/association.hpp"

#include <vector>

#include "catch.hpp"

using namespace plumbline;
using namespace plumbline::io;

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
