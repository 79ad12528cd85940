#include "plumbline/io/nearest.hpp"

#include <string>
#include <vector>

#include "catch.hpp"

using namespace plumbline::io;

TEST_CASE("nearest: insertions, deletions and replacements") {
  REQUIRE(edit_distance("", "") == 0);
  REQUIRE(edit_distance("", "abc") == 3);
  REQUIRE(edit_distance("window", "windows") == 1);
  REQUIRE(edit_distance("rate_hs", "rate_hz") == 1);
  REQUIRE(edit_distance("kitten", "sitting") == 3);
}

TEST_CASE("nearest: a name far from all is not guessed") {
  const std::vector<std::string> known{"list", "run", "evaluate", "simulate"};
  REQUIRE(nearest_name("rum", known) == "run");
  REQUIRE(nearest_name("evalute", known) == "evaluate");
  REQUIRE(nearest_name("help", known).empty());
  REQUIRE(nearest_name("", known).empty());
  REQUIRE(nearest_name(std::string(100'000, 'x'), known).empty());
  REQUIRE(suggestion("lost", known) == "did you mean \"list\"?");
  REQUIRE(suggestion("version", known) == "known are list, run, evaluate, simulate");
}
