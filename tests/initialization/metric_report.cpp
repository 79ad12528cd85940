#include "plumbline/initialization/metric_report.hpp"

#include "catch.hpp"
#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/lie/se3.hpp"

using namespace plumbline;

namespace {
struct Pose {
  bool applies = true;
  int applied = 0;
  double sigma = 0;
  bool apply_up_to_scale(const auto&, const SE3<double>&, const SE3<double>&, int&) { return ++applied, applies; }
  void apply_stationary(double, double accel_bias_sigma, int&, int&) { sigma = accel_bias_sigma; }
};
struct Initializer {
  bool has = true;
  struct {
    double accel_bias_sigma = 0.3;
  } values;
  bool has_estimate() const { return has; }
  const auto& options() const { return values; }
};
struct Frames {
  struct {
    SE3<double> T_world_body;
  } x;
  const auto& latest() const { return x; }
};
struct Components {
  struct {
    Frames all;
    const Frames& frames() const { return all; }
  } window;
  struct {
    SE3<double> T;
    const SE3<double>& T_body_cam() const { return T; }
  } rig_state;
  int navigation = 0;
  FrameReport report;
};
struct AtRest {
  struct {
    int all = 0;
    int& frames() { return all; }
  } window;
  struct {
    double stationary_state() const { return 1; }
  } propagation;
  int navigation = 0;
  FrameReport report;
};
}  // namespace

TEST_CASE("metric_report: a pose of uncertain scale where there is an estimate, and the pose takes it") {
  Pose pose;
  Components on;
  report_up_to_scale(pose, Initializer{false, {}}, on);
  CHECK((pose.applied == 0 && !on.report.has_metric_pose));
  pose.applies = false;
  report_up_to_scale(pose, Initializer{}, on);
  CHECK((pose.applied == 1 && !on.report.has_metric_pose));
  pose.applies = true;
  report_up_to_scale(pose, Initializer{}, on);
  CHECK(on.report.has_metric_pose);
  CHECK(on.report.reason == HealthReason::scale_uncertain);
}

TEST_CASE("metric_report: the pose of a body at rest is metric, and its tilt as uncertain as the accelerometer bias") {
  Pose pose;
  AtRest on;
  report_stationary(pose, Initializer{}, on);
  CHECK(on.report.has_metric_pose);
  CHECK(on.report.reason == HealthReason::aligning);
  CHECK(pose.sigma == 0.3);
}
