#include "plumbline/estimator/outage.hpp"

#include <cmath>

#include "catch.hpp"
#include "estimator/small_parts.hpp"

using namespace plumbline;
using test::SmallParts;

namespace {

struct Run : SmallParts {
  Outage<Parts, NoMap::Discard<double>> outage{options};
  TimeNs t_ns = 0;

  Run() {
    draw(0);
    const auto first = view(t_ns);
    const int slot = window->reset(first, {}, *tracker, rig_state);
    window->adopt_keyframe(first, slot, *tracker, propagation, navigation);
    tracker->set_usable(t_ns);
    navigation.set_covariance(zeros<double, 6, 6>());
  }
  bool hold(HealthReason failure) {
    const auto now = view(t_ns += 50'000'000);
    report = {};
    return outage.hold(now, failure, options.recovery.max_lost_frames, *tracker, *window, navigation, report);
  }
};

}  // namespace

TEST_CASE("outage: a body that is not observed may move at a constant unknown velocity") {
  Run run;
  for (int k = 1; k <= 10; ++k) {
    REQUIRE(run.hold(HealthReason::few_features));
    const double t_s = 0.05 * k;
    CHECK(std::sqrt(run.navigation.covariance()(3, 3)) == Approx(run.options.recovery.lost_speed * t_s));
    CHECK(std::sqrt(run.navigation.covariance()(0, 0)) == Approx(run.options.recovery.lost_rate * t_s));
    CHECK(run.report.reason == HealthReason::few_features);
    CHECK_FALSE(run.report.is_bridged);
  }
}

TEST_CASE("outage: as many images with contrast are tried as the options say, then a reset is due") {
  Run run;
  for (int k = 0; k < run.options.recovery.max_lost_frames; ++k) REQUIRE(run.hold(HealthReason::few_inliers));
  CHECK_FALSE(run.hold(HealthReason::few_inliers));
}

TEST_CASE("outage: images without contrast are no attempt, but the time is limited") {
  Run run;
  run.gray.fill(50);
  int held = 0;
  while (run.hold(HealthReason::few_features)) ++held;
  CHECK(held * 0.05 == Approx(run.options.recovery.max_imu_only_s).margin(0.06));
  CHECK(held > run.options.recovery.max_lost_frames);
}

TEST_CASE("outage: a repeated image bridges the outage for a time, and never causes a reset") {
  Run run;
  for (int k = 0; k < 100; ++k) {
    REQUIRE(run.hold(HealthReason::images_repeat));
    CHECK(run.report.is_bridged == (0.05 * (k + 1) < run.options.recovery.max_imu_only_s - 1e-9));
  }
}

TEST_CASE("outage: a pose found ends the count of images") {
  Run run;
  for (int k = 0; k < run.options.recovery.max_lost_frames; ++k) REQUIRE(run.hold(HealthReason::few_inliers));
  run.outage.found_pose(run.propagation, run.view(run.t_ns += 1));
  run.tracker->set_usable(run.t_ns);
  for (int k = 0; k < run.options.recovery.max_lost_frames; ++k) REQUIRE(run.hold(HealthReason::few_inliers));
  CHECK_FALSE(run.hold(HealthReason::few_inliers));
}
