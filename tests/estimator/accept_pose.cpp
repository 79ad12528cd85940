#include "plumbline/estimator/accept_pose.hpp"

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

TEST_CASE("accept_pose: window, navigation state and report follow a frame without IMU factors") {
  SmallParts parts;
  parts.draw(0);
  const auto first = parts.view(0);
  const int slot = parts.window->reset(first, {}, *parts.tracker, parts.rig_state);
  parts.window->adopt_keyframe(first, slot, *parts.tracker, parts.propagation, parts.navigation);
  const SE3<double> T({}, {0.1, 0, 0});
  const auto view = parts.view(50'000'000);
  accept_alone(parts.components(), view, {T}, 1e-4 * identity<double, 6>());
  CHECK(parts.window->frames().latest().T_world_body.p() == T.p());
  CHECK(parts.navigation.T_world_body().p() == T.p());
  CHECK(parts.navigation.covariance()(3, 3) > 1e-4);
  CHECK(parts.report.tracked == parts.window->landmarks().tracked_count());
  CHECK(parts.tracker->outage_s(view.t_ns) == 0);
}

namespace {
/// What inflates the uncertainty of the world frame.
struct Suspicion {
  double jump_rad = 0;
  bool passes = true;
  double gyro_jump_rotation() const { return jump_rad; }
  bool passes_gate(const auto&, const SE3<double>&) const { return passes; }
};
}  // namespace

TEST_CASE("accept_pose: a jump of the gyroscope bias, and a contradiction beyond the gate, inflate the world frame") {
  Prediction<FrameValue<double, VisualLayout>, double> predicted;
  predicted.state.T_world_body = SE3<double>({}, {0.5, 0, 0});
  const auto variance_after = [&](const Suspicion& found, bool is_inconsistent, int k) {
    SmallParts::Window::Nav navigation{WorldFrameUncertainty<double>(0)};
    FrameReport report;
    report.is_inconsistent = is_inconsistent;
    inflate_world_frame(found, report, predicted, navigation);
    return double(navigation.world().at(SE3<double>({}, {1, 1, 1}))(k, k));
  };
  CHECK(variance_after({0, true}, false, 0) == 0);
  CHECK(variance_after({0.1, true}, false, 0) > 0);
  CHECK(variance_after({0, true}, true, 3) == 0);
  CHECK(variance_after({0, false}, true, 3) > 0);
  CHECK(variance_after({0, false}, false, 3) == 0);
}
