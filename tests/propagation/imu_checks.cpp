#include "plumbline/propagation/imu_checks.hpp"

#include "catch.hpp"
#include "propagation/steady_samples.hpp"

using namespace plumbline;

namespace {
using Checks = ImuChecks<double>;
Mat<double, 6, 6> sure() { return 1e-10 * Mat<double, 6, 6>::Identity(); }
struct View {
  SE3<double> T_world_previous;
  double dt = 0.1;
};
}  // namespace

TEST_CASE("imu_checks: a jump of the gyroscope bias is corrected once, and bounds the rotation error of that frame") {
  const InertialOptions options;
  Checks checks(options);
  const Vec<double, 3> jump(0, 0, 0.2);  // [rad/s]
  NavState<double> x;
  int jumps = 0;
  CHECK(checks.innovation_gate(options) == options.innovation_gate);
  for (int k = 0; k < 20 && jumps == 0; ++k) {
    checks.advance(0.05);
    checks.begin_update();
    x = {};
    jumps += checks.detect_jump(x, SE3<double>(SO3<double>::exp(-0.05 * jump), Vec<double, 3>(1, 2, 3)), sure(), 0.05);
  }
  REQUIRE(jumps == 1);
  CHECK(x.bias_gyro.z() > 0.02);
  CHECK(x.T_world_body.p() == Vec<double, 3>(1, 2, 3));
  CHECK(checks.jump_rotation() > 0);
  CHECK(checks.is_inconsistent());
  CHECK(checks.innovation_gate(options) == options.innovation_gate_after_jump);
  checks.begin_update();
  CHECK(checks.jump_rotation() == 0);
}

TEST_CASE("imu_checks: factors that the window does not satisfy, in the order of the reasons") {
  const InertialOptions options;
  Checks checks(options);
  test::SteadySamples<double> samples;
  samples.advance(0.1);
  CHECK(checks.diagnose(0.9 * options.max_disagreement, samples.imu, options) == HealthReason::none);
  CHECK_FALSE(checks.is_inconsistent());
  CHECK(checks.diagnose(1.1 * options.max_disagreement, samples.imu, options) == HealthReason::imu_disagrees);
  samples.imu.begin_frame(samples.now);
  samples.imu.integrate(samples.now + 1'000'000'000, samples.state);  // without samples
  CHECK(checks.diagnose(1.1 * options.max_disagreement, samples.imu, options) == HealthReason::no_imu_data);
  CHECK(checks.is_inconsistent());  // whatever the reason
}

TEST_CASE("imu_checks: a wrong accelerometer is found, and the samples since the keyframe are distrusted") {
  const InertialOptions options;
  Checks checks(options);
  test::SteadySamples<double> samples;
  SamplesSinceKeyframe<double> since_keyframe;
  // The IMU predicts rest; after four seconds its images show a body that accelerates by 3 m/s^2.
  double t = 0, v = 0, x = 0;
  for (int k = 0; k < 100 && !checks.is_accel_suspect(); ++k) {
    samples.advance(0.1);
    View view{SE3<double>({}, {x, 0, 0})};
    NavState<double> before;
    before.T_world_body = view.T_world_previous;
    x += 0.1 * v;
    v += t > 4 ? 0.3 : 0;
    t += 0.1;
    checks.check_accelerometer(SE3<double>({}, {x, 0, 0}), sure(), /*is_stationary=*/false, before, before, view,
                               options, samples.imu, since_keyframe);
  }
  REQUIRE(checks.is_accel_suspect());
  CHECK(t > 4.4);
  CHECK(t < 6);
  CHECK(since_keyframe.is_suspect());
  CHECK(samples.imu.is_unusable());
  checks.restart(options.accel_check);
  CHECK_FALSE(checks.is_accel_suspect());
}

TEST_CASE("imu_checks: at rest the accelerometer is not checked") {
  const InertialOptions options;
  Checks checks(options);
  test::SteadySamples<double> samples;
  SamplesSinceKeyframe<double> since_keyframe;
  double t = 0, x = 0;
  for (int k = 0; k < 100; ++k, t += 0.1) {
    samples.advance(0.1);
    const View view{SE3<double>({}, {x, 0, 0})};
    x += t > 4 ? 0.3 * (t - 4) : 0;
    checks.check_accelerometer(SE3<double>({}, {x, 0, 0}), sure(), /*is_stationary=*/true, {}, {}, view, options,
                               samples.imu, since_keyframe);
  }
  CHECK_FALSE(checks.is_accel_suspect());
}
