#include "plumbline/initialization/initialization.hpp"

#include <memory>

#include "catch.hpp"
#include "estimator/small_parts.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;
using test::SmallParts;

namespace {

using Of = Initialization<SmallParts::Parts>;

/// A rig with depth is initialized by its first view.
struct Run {
  SmallParts parts;
  Of initialization{parts.options};

  void see(TimeNs t_ns) { initialization.set_first_view(parts.view(t_ns), parts.components()); }
};

template <class Vision, class... Inertial>
using InitializationOf = Initialization<Composition<Rig<Vision, Inertial...>, Features<Points<60>>, SlidingWindow<4>>>;
using Camera = Pinhole<double>;

}  // namespace

TEST_CASE("initialization: of a rig with depth, done by a first view that shows enough") {
  Run run;
  CHECK(run.initialization.report().stage == InitStage::few_features);
  run.parts.draw(0);
  run.see(5);
  const InitReport& report = run.initialization.report();
  CHECK((report.stage == InitStage::done && report.done_ns == 5 && report.rejected == 0));
  CHECK(report.features >= run.parts.options.recovery.min_landmarks);
  CHECK(run.initialization.first_view_ns() == 5);
  CHECK(run.parts.status.state() == TrackingState::nominal);
  CHECK(run.parts.window->is_latest_keyframe());
  CHECK(run.parts.report.tracked == run.parts.window->landmarks().tracked_count());
}

TEST_CASE("initialization: a view that shows too little says why, and the next one may do") {
  Run run;
  run.parts.gray.fill(100);
  run.see(1);
  CHECK(run.initialization.report().stage == InitStage::few_features);
  CHECK(run.parts.report.reason == HealthReason::few_features);
  CHECK(run.parts.status.state() == TrackingState::uninitialized);
  run.parts.draw(0);
  run.parts.depth.fill(0);
  run.see(2);
  CHECK(run.parts.report.reason == HealthReason::no_depth);
  CHECK(run.initialization.report().features >= run.parts.options.recovery.min_landmarks);
  CHECK(run.initialization.first_view_ns() == 0);
  CHECK_FALSE(run.parts.report.has_metric_pose);
  run.parts.depth.fill(2000);
  run.see(3);
  CHECK(run.initialization.report().stage == InitStage::done);
  CHECK(run.parts.status.state() == TrackingState::nominal);
}

TEST_CASE("initialization: a reset starts it at the pose and covariance of the navigation state") {
  Run run;
  run.parts.draw(0);
  run.see(1);
  const Vec<double, 3> p(1, 2, 3);
  run.parts.navigation.move_to(SE3<double>({}, p));
  run.parts.window->frames().set_latest({SE3<double>({}, p)});
  run.initialization.mark_lost(run.parts.window->frames(), run.parts.navigation);
  run.see(2);
  CHECK(run.initialization.report().done_ns == 2);
  CHECK(run.parts.navigation.T_world_body().p() == p);
  CHECK(run.parts.window->frames().size() == 1);
}

TEST_CASE("initialization: what a rig does not have takes no part in it") {
  Run run;
  run.parts.draw(0);
  run.see(1);
  const auto view = run.parts.view(2);
  CHECK_FALSE(run.initialization.add_pose(view, identity<double, 6>(), run.parts.components()));  // no alignment
  run.initialization.verify_scale(view, run.parts.propagation, true);
  CHECK((run.initialization.is_scale_converged() && !run.initialization.is_rejected()));
}

TEST_CASE("initialization: with an IMU the series of poses must be unbroken") {
  CHECK(Of::lost_frame_limit(12) == 12);
  CHECK(InitializationOf<Mono<Camera>>::lost_frame_limit(12) == 12);
  CHECK(InitializationOf<Mono<Camera>, Imu>::lost_frame_limit(12) == 0);
  CHECK(InitializationOf<Rgbd<Camera>, Imu>::lost_frame_limit(12) == 0);
}
