// IMU samples between frames: each is integrated once, whatever the image rate.
#include "plumbline/propagation/imu_integrator.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/core/matrix.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs ms = 1'000'000, period = 5 * ms;
constexpr double rate_z = 0.3;  // [rad/s]

ImuNoise noise() { return {.gyro_density = 1e-3, .accel_density = 1e-2, .gyro_walk = 1e-5, .accel_walk = 1e-4}; }
/// Turns evenly about z; small differences, so that no sensor seems frozen.
ImuSample sample_at(TimeNs t_ns) {
  const double wiggle = 1e-9 * double(t_ns / period % 7);
  return {t_ns, {wiggle, 0, rate_z}, {0, wiggle, 9.81}};
}

template <class S>
struct Frames {
  ImuIntegrator<S> imu;
  NavState<S> state;
  explicit Frames(const Imu& sensor = {}) : imu(sensor, noise()) {}

  /// Samples in (from, to].
  void read(TimeNs from, TimeNs to, bool after_a_frame) {
    for (TimeNs t = from + period; t <= to; t += period)
      REQUIRE(imu.add(sample_at(t), after_a_frame ? &state : nullptr));
  }
  double duration() const { return double(imu.since_frame().increment().duration); }
  double angle() const { return double(imu.since_frame().increment().delta.dR.log().z()); }
};

}  // namespace

TEMPLATE_TEST_CASE("imu_integrator: an increment from frame to frame", "", float, double) {
  Frames<TestType> frames;
  frames.read(-50 * ms, 110 * ms, false);
  frames.imu.begin_frame(0);
  frames.imu.integrate(100 * ms, frames.state);
  CHECK(frames.duration() == Approx(0.1).epsilon(1e-6));
  CHECK(frames.angle() == Approx(0.1 * rate_z).epsilon(1e-5));
  CHECK_FALSE(frames.imu.is_unusable());
  // The next one begins where this one ended, although none of its samples is at a frame time.
  frames.imu.begin_frame(100 * ms);
  frames.read(110 * ms, 140 * ms, true);
  frames.imu.integrate(133 * ms, frames.state);
  CHECK(frames.duration() == Approx(0.033).epsilon(1e-6));
}

TEMPLATE_TEST_CASE("imu_integrator: a suspect accelerometer inflates the covariance of the velocity", "", float,
                   double) {
  using S = TestType;
  Frames<S> frames;
  frames.read(-50 * ms, 110 * ms, false);
  frames.imu.begin_frame(0);
  frames.imu.inflate_accelerometer_noise(S(20));
  frames.imu.integrate(100 * ms, frames.state);
  CHECK(frames.imu.is_unusable());
  CHECK_FALSE(frames.imu.is_missing());
  CHECK(double(frames.imu.since_frame().increment().covariance(6, 6)) == Approx(20 * 20 * 0.1).epsilon(0.01));
  CHECK(frames.angle() == Approx(0.1 * rate_z).epsilon(1e-5));
  frames.imu.inflate_accelerometer_noise(S(0));
  CHECK_FALSE(frames.imu.is_unusable());
}

TEMPLATE_TEST_CASE("imu_integrator: no sample is lost while images are missing", "", float, double) {
  Frames<TestType> frames;
  frames.read(-50 * ms, 0, false);
  frames.imu.begin_frame(0);
  constexpr TimeNs pause = 10'000 * ms;  // several buffers
  REQUIRE(pause / period > 3 * TimeNs(512));
  frames.read(0, pause, true);
  frames.imu.integrate(pause, frames.state);
  CHECK(frames.duration() == Approx(10).epsilon(1e-4));
  CHECK(frames.angle() == Approx(10 * rate_z).epsilon(1e-3));
  CHECK_FALSE(frames.imu.is_missing());
}

TEMPLATE_TEST_CASE("imu_integrator: detects missing and saturated samples", "", float, double) {
  Frames<TestType> frames;
  frames.read(-50 * ms, 20 * ms, false);
  frames.imu.begin_frame(0);
  frames.imu.integrate(100 * ms, frames.state);
  CHECK(frames.imu.is_missing());
  CHECK(frames.imu.is_unusable());

  Frames<TestType> saturated;
  saturated.read(-50 * ms, 50 * ms, false);
  ImuSample loud = sample_at(55 * ms);
  loud.accel.x() = 1e3;
  REQUIRE(saturated.imu.add(loud, nullptr));
  saturated.read(55 * ms, 100 * ms, false);
  saturated.imu.begin_frame(0);
  saturated.imu.integrate(100 * ms, saturated.state);
  CHECK_FALSE(saturated.imu.is_missing());
  CHECK(saturated.imu.is_unusable());
}

TEMPLATE_TEST_CASE("imu_integrator: the time offset of the camera is applied", "", float, double) {
  Imu sensor;
  sensor.camera_time_offset_s = 0.02;
  Frames<TestType> frames(sensor);
  CHECK(frames.imu.time_of(100 * ms) == 120 * ms);
  frames.read(-50 * ms, 120 * ms, false);
  frames.imu.begin_frame(0);
  frames.imu.integrate(100 * ms, frames.state);
  CHECK(frames.duration() == Approx(0.1).epsilon(1e-6));
  CHECK_FALSE(frames.imu.is_missing());  // the newest sample is just in time
}
