#include "plumbline/frontend/depth_filters.hpp"

#include "catch.hpp"
#include "plumbline/geometry/depth_filter.hpp"

using namespace plumbline;

TEST_CASE("depth_filters: every landmark finds its own filter again, and a new one finds a new filter") {
  DepthFilters<DepthFilter<float>, 4> depth_filters;
  for (std::uint32_t id = 0; id < 4; ++id) {
    REQUIRE_FALSE(depth_filters.of(id).known());
    depth_filters.of(id) = DepthFilter<float>::around(float(id + 1));
  }
  for (std::uint32_t id = 0; id < 4; ++id) CHECK(depth_filters.of(id).mu == float(id + 1));
  CHECK_FALSE(depth_filters.of(6).known());  // takes the place of 2
  CHECK(depth_filters.of(1).mu == 2.0f);
  CHECK_FALSE(depth_filters.of(2).known());
}
