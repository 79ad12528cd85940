#include "plumbline/mapping/frame_window.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("frame_window: slots are kept, freed and used again") {
  FrameWindow<double, 3> window;
  const SE3<double> I;
  REQUIRE(window.insert(1, I) == 0);
  REQUIRE(window.insert(2, I) == 1);
  REQUIRE(window.insert(3, I) == 2);
  REQUIRE(window.full());
  REQUIRE(window.newest() == 2);
  window.remove(1);
  REQUIRE_FALSE(window[1].used);
  REQUIRE(window.insert(4, I) == 1);
  REQUIRE(window.newest() == 1);
  REQUIRE(window[1].sequence > window[2].sequence);
  window.clear();
  REQUIRE(window.size() == 0);
}

TEST_CASE("frame_window: a free pose composes, a fixed one adds its corrections up") {
  const SE3<double> T(SO3<double>::exp({0.3, -0.2, 0.5}), Vec<double, 3>(1, 2, 3));
  Vec<double, 6> a, b;
  a << 0.1, 0.2, -0.1, 0.3, 0.1, 0.2;
  b << -0.2, 0.1, 0.3, 0.1, -0.4, 0.2;

  WindowPose<double> free(T);
  free.add(a);
  free.add(b);
  REQUIRE(minus(free.value(), plus(plus(T, a), b)).norm() < 1e-12);
  REQUIRE(minus(free.linearization_point(), free.value()).norm() == 0);
  REQUIRE(free.correction().norm() == 0);

  WindowPose<double> fixed(T);
  fixed.fix_linearization_point();
  fixed.add(a);
  fixed.add(b);
  REQUIRE(minus(fixed.linearization_point(), T).norm() == 0);
  REQUIRE((fixed.correction() - a - b).norm() < 1e-15);
  REQUIRE(minus(fixed.value(), plus(T, Vec<double, 6>(a + b))).norm() < 1e-12);
}
