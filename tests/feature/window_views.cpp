#include "plumbline/feature/window_views.hpp"

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/solver/relative_equations.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;

namespace {

const SE3<double> T_body_cam(SO3<double>::exp({1, 0.2, 0}), Vec<double, 3>(0.1, 0, 0));

using Window = FrameWindow<double, VisualLayout, 3>;

/// Two frames; the second has moved away from its first estimate.
Window moved_window() {
  Window window;
  window.insert(1, {SE3<double>(SO3<double>::exp({0.3, -0.2, 0.1}), Vec<double, 3>(0.4, 0, -0.2))});
  window.insert(2, {SE3<double>(SO3<double>::exp({0, 0.1, 0}), Vec<double, 3>(1, 0, 0))});
  window.state(1).fix_first_estimates();
  window.state(1).add((Vec<double, 6>() << 0.1, 0, 0, 0, 0.2, 0).finished());
  return window;
}
const SE3<double>& first_estimate(const Window& window, int slot) {
  return window[slot].state.get<state::Pose>().first_estimate();
}

}  // namespace

TEST_CASE("window_views: a step of the anchor is seen as the transported step of the target, to first order") {
  Window window = moved_window();
  const SE3<double> T_a = first_estimate(window, 0), T_j = first_estimate(window, 1);
  RelativeEquations<double, 6, 3> pairs;
  WindowViews<double, 3>::set_transports(window, pairs);
  const Vec<double, 3> f = Vec<double, 3>(0.1, 0.2, 1).normalized();
  for (int i = 0; i < 6; ++i) {
    const Vec<double, 6> d = 1e-6 * Vec<double, 6>::Unit(i), d_target = -pairs.transport(0, 1) * d;
    const RelativeView<double> by_anchor(plus(T_a, d), T_j, T_body_cam),
        by_target(T_a, plus(T_j, d_target), T_body_cam), before(T_a, T_j, T_body_cam);
    const Vec<double, 3> P = before.scaled_point(f, 0.5);
    REQUIRE((by_anchor.scaled_point(f, 0.5) - by_target.scaled_point(f, 0.5)).norm() < 1e-11);
    REQUIRE((by_anchor.scaled_point(f, 0.5) - P).norm() > 1e-8);
  }
}

TEST_CASE("window_views: views are those of the current poses, transports those of the first estimates") {
  Window window = moved_window();
  WindowViews<double, 3> views;
  RelativeEquations<double, 6, 3> pairs;
  const auto update = [&] {
    views.update(window, T_body_cam);
    views.set_transports(window, pairs);
  };
  update();
  const RelativeView<double> now(window.T_world_body(0), window.T_world_body(1), T_body_cam);
  const Vec<double, 3> f = Vec<double, 3>(0.1, 0.2, 1).normalized();
  REQUIRE(views(0, 1).scaled_point(f, 0.5) == now.scaled_point(f, 0.5));
  const Mat<double, 6, 6> transport = pairs.transport(0, 1);
  const SE3<double> T_1_0 = window.T_world_body(1).inverse() * window.T_world_body(0);
  REQUIRE((transport - T_1_0.adjoint()).norm() > 0.01);

  window.state(1).add((Vec<double, 6>() << 0, 0.1, 0, 0, 0, 0.1).finished());
  update();
  REQUIRE(pairs.transport(0, 1) == transport);
  REQUIRE((views(0, 1).scaled_point(f, 0.5) - now.scaled_point(f, 0.5)).norm() > 0.01);
}
