#include "plumbline/testing/frame_drops.hpp"

#include <algorithm>

#include "catch.hpp"

using namespace plumbline::testing;

TEST_CASE("frame_drops: the share that was asked for is missing, in gaps of all lengths up to the longest") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    for (const double share : {0.05, 0.2, 0.4}) {
      const std::vector<bool> kept = frames_kept(20000, share, 7, seed);
      std::vector<int> gaps(9, 0);
      int missing = 0, gap = 0;
      for (const bool there : kept) {
        if (there && gap > 0) ++gaps[std::size_t(std::min(gap, 8))];
        gap = there ? 0 : gap + 1;
        missing += !there;
      }
      CAPTURE(seed, share, missing);
      REQUIRE(kept.front());
      REQUIRE(missing == Approx(share * 20000).epsilon(0.1));
      for (int length = 1; length <= 7; ++length) REQUIRE(gaps[std::size_t(length)] > 10);
      REQUIRE(gaps[8] == 0);
    }
  }
  REQUIRE(frames_kept(300, 0.2, 7, 1) == frames_kept(300, 0.2, 7, 1));
  REQUIRE(frames_kept(300, 0.2, 7, 1) != frames_kept(300, 0.2, 7, 2));
  const std::vector<bool> all = frames_kept(50, 0, 7, 1);
  REQUIRE(std::count(all.begin(), all.end(), true) == 50);
}
