#include "plumbline/motion/accelerometer_check.hpp"

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// A body that is driven to and fro, places seen with noise, readings that may err.
template <class S>
struct Drive {
  AccelerometerCheckOptions options;
  AccelerometerCheck<S> check{options};
  testing::Gaussian noise{3};
  double dt = 0.05, sigma_m = 4e-4, t = 0;
  Vec<double, 3> seen = place(0);

  static Vec<double, 3> place(double t) { return {std::sin(t), 0.5 * std::cos(2 * t), 0.1 * t}; }
  static Vec<double, 3> velocity(double t) { return {std::cos(t), -std::sin(2 * t), 0.1}; }

  /// One frame; the readings err by e [m/s^2], the images see the body d further away from here on [m].
  void go_on(const Vec<double, 3>& e, const Vec<double, 3>& d = Vec<double, 3>::Zero(), bool disputed = false) {
    const Vec<double, 3> from = place(t), v_from = velocity(t);
    t += dt;
    NavState<S> before, foretold;
    before.T_world_body = SE3<S>(SO3<S>(), (from + Vec<double, 3>(0.2, 0.1, 0)).cast<S>());  // nobody knows it exactly
    before.v_world_body = (v_from + Vec<double, 3>(0, 0.1, -0.1)).cast<S>();
    const Vec<double, 3> fallen = place(t) - from - dt * v_from + 0.5 * dt * dt * e;
    foretold.T_world_body = SE3<S>(SO3<S>(), before.T_world_body.p() + S(dt) * before.v_world_body + fallen.cast<S>());
    foretold.v_world_body = before.v_world_body + (velocity(t) - v_from + dt * e).cast<S>();
    const Vec<double, 3> now = place(t) + d + sigma_m * Vec<double, 3>(noise(), noise(), noise());
    check.update(now.cast<S>(), S(sigma_m), seen.cast<S>(), before, foretold, S(dt), disputed);
    seen = now;
  }
  /// Frames until it is in doubt; `frames` where it never is.
  int until_doubt(int frames, const Vec<double, 3>& e, bool disputed = false) {
    int k = 0;
    for (; k < frames && !check.in_doubt(); ++k) go_on(e, Vec<double, 3>::Zero(), disputed);
    return k;
  }
};

const Vec<double, 3> right = Vec<double, 3>::Zero(), wrong(0.7, -0.7, 0.3);

}  // namespace

TEMPLATE_TEST_CASE("accelerometer_check: one that is right is believed, and one that errs by less than a bias may", "",
                   float, double) {
  Drive<TestType> drive;
  CHECK(drive.until_doubt(2000, right) == 2000);
  CHECK(drive.until_doubt(2000, 0.4 * wrong) == 2000);
}

TEMPLATE_TEST_CASE("accelerometer_check: one that is wrong is found out, and believed again later", "", float, double) {
  Drive<TestType> drive;
  drive.dt = GENERATE(0.01, 0.05, 0.25);  // 100, 20 and 4 Hz
  drive.sigma_m = 4e-4 * std::min(1.0, drive.dt / 0.05);
  const int second = int(std::lround(1 / drive.dt));
  REQUIRE(drive.until_doubt(4 * second, right) == 4 * second);
  CAPTURE(drive.dt);
  CHECK(drive.until_doubt(2 * second, wrong) * drive.dt < 2 * drive.options.half_s + 3 * drive.dt);
  int frames = 0;
  for (; drive.check.in_doubt() && frames < 100 * second; ++frames) drive.go_on(right);
  CHECK(frames * drive.dt > drive.options.settles_s - 2 * drive.dt);
  CHECK(frames * drive.dt < drive.options.settles_s + 2 * drive.options.half_s + 3 * drive.dt);
}

TEMPLATE_TEST_CASE("accelerometer_check: images that jump, or move on with another speed, do not speak against it", "",
                   float, double) {
  Drive<TestType> drive;
  REQUIRE(drive.until_doubt(80, right) == 80);
  Vec<double, 3> d = Vec<double, 3>::Zero();
  for (int k = 0; k < 200; ++k) {
    if (k % 40 == 10) d += Vec<double, 3>(0.05, 0, 0);
    if (k > 150) d += 0.05 * Vec<double, 3>(0, 0.4, 0);
    drive.go_on(right, d);
    REQUIRE_FALSE(drive.check.in_doubt());
  }
}

TEMPLATE_TEST_CASE("accelerometer_check: less is enough where more speaks against it", "", float, double) {
  Drive<TestType> drive;
  REQUIRE(drive.until_doubt(80, right) == 80);
  CHECK(drive.until_doubt(100, 0.45 * wrong) == 100);
  CHECK(drive.until_doubt(20, 0.45 * wrong, true) < 20);
}

TEMPLATE_TEST_CASE("accelerometer_check: before it was right for some time it is not to blame", "", float, double) {
  Drive<TestType> drive;
  CHECK(drive.until_doubt(400, wrong) == 400);
}

TEMPLATE_TEST_CASE("accelerometer_check: frames that are not next to each other are not compared", "", float, double) {
  Drive<TestType> drive;
  REQUIRE(drive.until_doubt(80, right) == 80);
  for (int k = 0; k < 40; ++k) {
    if (k % 8 == 0) drive.check.interrupt();
    drive.go_on(wrong);
  }
  CHECK_FALSE(drive.check.in_doubt());
}
