#include "plumbline/start/depth.hpp"

#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("depth: the first frame is enough, and nothing is kept of it", "", float, double) {
  using Start = DepthStart<TestType>;
  STATIC_REQUIRE(!Start::needs_second_view);
  STATIC_REQUIRE(std::is_empty_v<Start>);
  STATIC_REQUIRE(std::is_empty_v<typename Start::Options>);
  Start start({});
  REQUIRE(&start.visual() == &start);
}
