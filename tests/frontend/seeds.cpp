#include "plumbline/frontend/seeds.hpp"

#include "catch.hpp"
#include "plumbline/geometry/depth_filter.hpp"

using namespace plumbline;

TEST_CASE("seeds: every landmark finds its own filter again, and a new one finds a new filter") {
  Seeds<DepthFilter<float>, 4> seeds;
  for (std::uint32_t id = 0; id < 4; ++id) {
    REQUIRE_FALSE(seeds.of(id).known());
    seeds.of(id) = DepthFilter<float>::around(float(id + 1));
  }
  for (std::uint32_t id = 0; id < 4; ++id) CHECK(seeds.of(id).mu == float(id + 1));
  CHECK_FALSE(seeds.of(6).known());  // takes the place of 2
  CHECK(seeds.of(1).mu == 2.0f);
  CHECK_FALSE(seeds.of(2).known());
}
