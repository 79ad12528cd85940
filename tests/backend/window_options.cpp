#include "plumbline/backend/window_options.hpp"

#include "catch.hpp"
#include "plumbline/backend/direct_gauss_newton.hpp"

using namespace plumbline;

TEST_CASE("window_options: a frame that is no keyframe, and a bundle beside frames alone, take fewer iterations") {
  const WindowOptions options;
  CHECK(options.frame_iterations < options.solver.max_iterations);
  CHECK(DirectOptions().solver.max_iterations < options.solver.max_iterations);
  CHECK(DirectOptions().frame_iterations == options.frame_iterations);
}
