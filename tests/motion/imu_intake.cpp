// Readings between frames: none lost, none twice, whenever the images come.
#include "plumbline/motion/imu_intake.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/core/matrix.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs ms = 1'000'000, period = 5 * ms;
constexpr double rate_z = 0.3;  // [rad/s]

ImuNoise noise() { return {.gyro_density = 1e-3, .accel_density = 1e-2, .gyro_walk = 1e-5, .accel_walk = 1e-4}; }
/// Turns evenly about z; small differences, so that no sensor seems frozen.
ImuSample reading(TimeNs t_ns) {
  const double wiggle = 1e-9 * double(t_ns / period % 7);
  return {t_ns, {wiggle, 0, rate_z}, {0, wiggle, 9.81}};
}

template <class S>
struct Intake {
  ImuIntake<S> imu;
  NavState<S> state;
  explicit Intake(const Imu& sensor = {}) : imu(sensor, noise()) {}

  /// Readings in (from, to].
  void read(TimeNs from, TimeNs to, bool after_a_frame) {
    for (TimeNs t = from + period; t <= to; t += period) REQUIRE(imu.add(reading(t), after_a_frame ? &state : nullptr));
  }
  double duration() const { return double(imu.since_frame().increment().duration); }
  double angle() const { return double(imu.since_frame().increment().delta.dR.log().z()); }
};

}  // namespace

TEMPLATE_TEST_CASE("imu_intake: an increment from frame to frame", "", float, double) {
  Intake<TestType> intake;
  intake.read(-50 * ms, 110 * ms, false);
  intake.imu.begin_frame(0);
  intake.imu.integrate(100 * ms, intake.state);
  CHECK(intake.duration() == Approx(0.1).epsilon(1e-6));
  CHECK(intake.angle() == Approx(0.1 * rate_z).epsilon(1e-5));
  CHECK_FALSE(intake.imu.blind());
  // The next one begins where this one ended, although none of its readings is at a frame's time.
  intake.imu.begin_frame(100 * ms);
  intake.read(110 * ms, 140 * ms, true);
  intake.imu.integrate(133 * ms, intake.state);
  CHECK(intake.duration() == Approx(0.033).epsilon(1e-6));
}

TEMPLATE_TEST_CASE("imu_intake: an accelerometer in doubt tells nothing of the way", "", float, double) {
  using S = TestType;
  Intake<S> intake;
  intake.read(-50 * ms, 110 * ms, false);
  intake.imu.begin_frame(0);
  intake.imu.doubt_accelerometer(S(20));
  intake.imu.integrate(100 * ms, intake.state);
  CHECK(intake.imu.blind());
  CHECK_FALSE(intake.imu.missing());
  CHECK(double(intake.imu.since_frame().increment().covariance(6, 6)) == Approx(20 * 20 * 0.1).epsilon(0.01));
  CHECK(intake.angle() == Approx(0.1 * rate_z).epsilon(1e-5));
  intake.imu.doubt_accelerometer(S(0));
  CHECK_FALSE(intake.imu.blind());
}

TEMPLATE_TEST_CASE("imu_intake: images that do not come lose no reading", "", float, double) {
  Intake<TestType> intake;
  intake.read(-50 * ms, 0, false);
  intake.imu.begin_frame(0);
  constexpr TimeNs pause = 10'000 * ms;  // several buffers
  REQUIRE(pause / period > 3 * TimeNs(512));
  intake.read(0, pause, true);
  intake.imu.integrate(pause, intake.state);
  CHECK(intake.duration() == Approx(10).epsilon(1e-4));
  CHECK(intake.angle() == Approx(10 * rate_z).epsilon(1e-3));
  CHECK_FALSE(intake.imu.missing());
}

TEMPLATE_TEST_CASE("imu_intake: says when readings are missing or at their rails", "", float, double) {
  Intake<TestType> intake;
  intake.read(-50 * ms, 20 * ms, false);
  intake.imu.begin_frame(0);
  intake.imu.integrate(100 * ms, intake.state);
  CHECK(intake.imu.missing());
  CHECK(intake.imu.blind());

  Intake<TestType> at_rail;
  at_rail.read(-50 * ms, 50 * ms, false);
  ImuSample loud = reading(55 * ms);
  loud.accel.x() = 1e3;
  REQUIRE(at_rail.imu.add(loud, nullptr));
  at_rail.read(55 * ms, 100 * ms, false);
  at_rail.imu.begin_frame(0);
  at_rail.imu.integrate(100 * ms, at_rail.state);
  CHECK_FALSE(at_rail.imu.missing());
  CHECK(at_rail.imu.blind());
}

TEMPLATE_TEST_CASE("imu_intake: a camera's clock beside that of the IMU", "", float, double) {
  Imu sensor;
  sensor.camera_time_offset_s = 0.02;
  Intake<TestType> intake(sensor);
  CHECK(intake.imu.time_of(100 * ms) == 120 * ms);
  intake.read(-50 * ms, 120 * ms, false);
  intake.imu.begin_frame(0);
  intake.imu.integrate(100 * ms, intake.state);
  CHECK(intake.duration() == Approx(0.1).epsilon(1e-6));
  CHECK_FALSE(intake.imu.missing());  // the newest reading is just there
}
