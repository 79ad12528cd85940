#include "plumbline/mapping/window_views.hpp"

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("window_views: residuals at the current poses, Jacobians at the linearization points") {
  FrameWindow<double, 3> window;
  const SE3<double> T_body_cam(SO3<double>::exp({1, 0.2, 0}), Vec<double, 3>(0.1, 0, 0));
  window.insert(1, SE3<double>());
  window.insert(2, SE3<double>(SO3<double>::exp({0, 0.1, 0}), Vec<double, 3>(1, 0, 0)));
  const SE3<double> before = window[1].pose.value();
  window.pose(1).fix_linearization_point();
  window.pose(1).add((Vec<double, 6>() << 0.1, 0, 0, 0, 0.2, 0).finished());

  WindowViews<double, 3> views;
  views.linearize(window, T_body_cam);
  const RelativeView<double> now(window[0].pose.value(), window[1].pose.value(), T_body_cam);
  const RelativeView<double> then(window[0].pose.value(), before, T_body_cam);
  const Vec<double, 3> f = Vec<double, 3>(0.1, 0.2, 1).normalized();
  REQUIRE(views.current(0, 1).scaled_point(f, 0.5) == now.scaled_point(f, 0.5));
  REQUIRE(views.linear(0, 1).scaled_point(f, 0.5) == then.scaled_point(f, 0.5));
  REQUIRE((now.scaled_point(f, 0.5) - then.scaled_point(f, 0.5)).norm() > 0.01);
}
