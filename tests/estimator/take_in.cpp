#include "plumbline/estimator/take_in.hpp"

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

TEST_CASE("take_in: a frame follows the navigation state in time, and is predicted from the latest pose") {
  SmallParts parts;
  parts.draw(0);
  const auto first = parts.view(1'000'000'000);
  const int slot = parts.window->reset(first, {SE3<double>({}, {1, 2, 3})}, *parts.tracker, parts.rig_state);
  parts.window->adopt_keyframe(first, slot, *parts.tracker, parts.propagation, parts.navigation);
  parts.tracker->set_usable(first.t_ns);
  parts.navigation.set_time(first.t_ns);
  const SmallParts::Sensors::Frame frame{
      1'050'000'000,
      {parts.gray.data(), SmallParts::width, SmallParts::height, SmallParts::width},
      {parts.depth.data(), SmallParts::width, SmallParts::height, SmallParts::width}};
  REQUIRE(parts.tracker->images().take_in(frame));
  View<SmallParts::Sensors> view = take_in(parts.components(), parts.rig, frame, /*is_first=*/false);
  CHECK(view.t_ns == frame.t_ns);
  CHECK(view.dt == Approx(0.05));
  CHECK(view.T_world_previous.p() == Vec<double, 3>(1, 2, 3));
  // The image is the same: the camera has not moved.
  const auto predicted = predict(parts.components(), view);
  CHECK((predicted.state.T_world_body.p() - Vec<double, 3>(1, 2, 3)).norm() < 1e-9);
  CHECK(predicted.state.T_world_body.rotation().log().norm() < 1e-3);
}
