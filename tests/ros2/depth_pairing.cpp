#include "plumbline_ros2/depth_pairing.hpp"

#include "catch.hpp"

using namespace plumbline::ros2;

namespace {

HeldImage at(plumbline::TimeNs t_ns) {
  HeldImage out;
  out.image.t_ns = t_ns;
  return out;
}

}  // namespace

TEST_CASE("an image has the depth image nearest in time, in whatever order they come") {
  DepthPairing pairing(10);
  REQUIRE(!pairing.add_gray(at(100)));
  const auto first = pairing.add_depth(at(103));
  REQUIRE(first);
  REQUIRE(first->first.image.t_ns == 100);
  REQUIRE(first->second.image.t_ns == 103);

  REQUIRE(!pairing.add_depth(at(195)));
  REQUIRE(!pairing.add_depth(at(201)));
  const auto second = pairing.add_gray(at(200));
  REQUIRE(second);
  REQUIRE(second->second.image.t_ns == 201);
  REQUIRE(!pairing.add_gray(at(196)));  // its depth was dropped with the pair
  REQUIRE(pairing.dropped() == 0);
}

TEST_CASE("images without depth are dropped and counted") {
  DepthPairing pairing(10);
  REQUIRE(!pairing.add_gray(at(100)));
  REQUIRE(!pairing.add_gray(at(200)));
  REQUIRE(!pairing.add_depth(at(211)));
  REQUIRE(!pairing.add_gray(at(300)));
  const auto pair = pairing.add_depth(at(310));
  REQUIRE(pair);
  REQUIRE(pair->first.image.t_ns == 300);
  REQUIRE(pairing.dropped() == 2);

  for (int i = 0; i < 100; ++i) REQUIRE(!pairing.add_gray(at(1000 + 100 * i)));
  REQUIRE(pairing.dropped() == 2 + 100 - DepthPairing::most_waiting);
}
