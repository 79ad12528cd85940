#include "plumbline/propagation/accelerometer_check.hpp"

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// A body that moves to and fro, positions measured with noise, IMU samples with an error.
template <class S>
struct Drive {
  AccelerometerCheckOptions options;
  AccelerometerCheck<S> check{options};
  testing::Gaussian noise{3};
  double dt = 0.05, sigma_m = 4e-4, t = 0;
  Vec<double, 3> seen = place(0);

  static Vec<double, 3> place(double t) { return {std::sin(t), 0.5 * std::cos(2 * t), 0.1 * t}; }
  static Vec<double, 3> velocity(double t) { return {std::cos(t), -std::sin(2 * t), 0.1}; }

  /// One frame; IMU samples with error e [m/s^2]; image positions are shifted by d from here on [m].
  void go_on(const Vec<double, 3>& e, const Vec<double, 3>& d = Vec<double, 3>::Zero(), bool inconsistent = false) {
    const Vec<double, 3> from = place(t), v_from = velocity(t);
    t += dt;
    NavState<S> before, predicted_state;
    before.T_world_body = SE3<S>(SO3<S>(), (from + Vec<double, 3>(0.2, 0.1, 0)).cast<S>());  // an inexact position
    before.v_world_body = (v_from + Vec<double, 3>(0, 0.1, -0.1)).cast<S>();
    const Vec<double, 3> fallen = place(t) - from - dt * v_from + 0.5 * dt * dt * e;
    predicted_state.T_world_body =
        SE3<S>(SO3<S>(), before.T_world_body.p() + S(dt) * before.v_world_body + fallen.cast<S>());
    predicted_state.v_world_body = before.v_world_body + (velocity(t) - v_from + dt * e).cast<S>();
    const Vec<double, 3> now = place(t) + d + sigma_m * Vec<double, 3>(noise(), noise(), noise());
    check.update(now.cast<S>(), S(sigma_m), seen.cast<S>(), before, predicted_state, S(dt), inconsistent);
    seen = now;
  }
  /// Frames until it is suspect; `frames` where it never is.
  int until_suspect(int frames, const Vec<double, 3>& e, bool inconsistent = false) {
    int k = 0;
    for (; k < frames && !check.is_suspect(); ++k) go_on(e, Vec<double, 3>::Zero(), inconsistent);
    return k;
  }
};

const Vec<double, 3> right = Vec<double, 3>::Zero(), wrong(0.7, -0.7, 0.3);

}  // namespace

TEMPLATE_TEST_CASE("accelerometer_check: no error, and an error within the bias prior, is not suspect", "", float,
                   double) {
  Drive<TestType> drive;
  CHECK(drive.until_suspect(2000, right) == 2000);
  CHECK(drive.until_suspect(2000, 0.4 * wrong) == 2000);
}

TEMPLATE_TEST_CASE("accelerometer_check: a large error is detected, and the suspicion expires", "", float, double) {
  Drive<TestType> drive;
  drive.dt = GENERATE(0.01, 0.05, 0.25);  // 100, 20 and 4 Hz
  drive.sigma_m = 4e-4 * std::min(1.0, drive.dt / 0.05);
  const int second = int(std::lround(1 / drive.dt));
  REQUIRE(drive.until_suspect(4 * second, right) == 4 * second);
  CAPTURE(drive.dt);
  CHECK(drive.until_suspect(2 * second, wrong) * drive.dt < 2 * drive.options.half_s + 3 * drive.dt);
  int frames = 0;
  for (; drive.check.is_suspect() && frames < 100 * second; ++frames) drive.go_on(right);
  CHECK(frames * drive.dt > drive.options.hold_s - 2 * drive.dt);
  CHECK(frames * drive.dt < drive.options.hold_s + 2 * drive.options.half_s + 3 * drive.dt);
}

TEMPLATE_TEST_CASE("accelerometer_check: image positions with a jump or a change of speed do not make it suspect", "",
                   float, double) {
  Drive<TestType> drive;
  REQUIRE(drive.until_suspect(80, right) == 80);
  Vec<double, 3> d = Vec<double, 3>::Zero();
  for (int k = 0; k < 200; ++k) {
    if (k % 40 == 10) d += Vec<double, 3>(0.05, 0, 0);
    if (k > 150) d += 0.05 * Vec<double, 3>(0, 0.4, 0);
    drive.go_on(right, d);
    REQUIRE_FALSE(drive.check.is_suspect());
  }
}

TEMPLATE_TEST_CASE("accelerometer_check: a smaller error suffices where the IMU factors are inconsistent, too", "",
                   float, double) {
  Drive<TestType> drive;
  REQUIRE(drive.until_suspect(80, right) == 80);
  CHECK(drive.until_suspect(100, 0.45 * wrong) == 100);
  CHECK(drive.until_suspect(20, 0.45 * wrong, true) < 20);
}

TEMPLATE_TEST_CASE("accelerometer_check: not suspect before it was consistent for some time", "", float, double) {
  Drive<TestType> drive;
  CHECK(drive.until_suspect(400, wrong) == 400);
}

TEMPLATE_TEST_CASE("accelerometer_check: frames that are not consecutive are not compared", "", float, double) {
  Drive<TestType> drive;
  REQUIRE(drive.until_suspect(80, right) == 80);
  for (int k = 0; k < 40; ++k) {
    if (k % 8 == 0) drive.check.interrupt();
    drive.go_on(wrong);
  }
  CHECK_FALSE(drive.check.is_suspect());
}
