// A body that turns to and fro, seen by a gyroscope and, late and turned, by a camera.
#include "plumbline/state/camera_imu_filter.hpp"

#include <algorithm>
#include <cmath>

#include "catch.hpp"

#include "plumbline/imu/noise.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

using Vec3 = Vec<double, 3>;

struct Wrong {
  double time_offset_s = 0;
  Vec3 turned = Vec3::Zero();
};

/// 10 Hz images of 2e-4 rad, IMU samples of 200 Hz; a correction applies from the next image on.
class Body {
 public:
  explicit Body(const Wrong& wrong, double activity = 1) : wrong_(wrong), activity_(activity) {}

  double time_offset_s() const { return in_force_s_; }
  void shift_time_offset(CameraImuFilter& filter, double step_s) {
    filter.shift_time_offset(step_s);
    in_force_s_ += step_s;
  }

  template <class S>
  void run(CameraImuFilter& filter, double seconds) {
    for (const double end = t_ + seconds; t_ < end; t_ += 0.1) {
      in_force_s_ += filter.take_time_offset();
      // The image of this time stamp was taken at t + wrong, and is used as one of t + the current offset.
      const double until = t_ + in_force_s_;
      ImuIncrement<S> increment(Vec<S, 3>::Zero(), Vec<S, 3>::Zero());
      const Vec3 rate = gyro(until);
      while (integrated_ < until - 1e-6) {
        const double begin = integrated_;
        integrated_ = std::min(begin + 0.005, until);
        ImuInterval<S> interval;
        interval.dt = S(integrated_ - begin);
        interval.gyro_begin = gyro(begin).cast<S>();
        interval.gyro_end = gyro(integrated_).cast<S>();
        interval.accel_begin = interval.accel_end = Vec<S, 3>(S(0), S(0), S(9.81));
        increment.integrate(interval, ImuNoise{1e-4, 1e-5, 1e-3, 1e-4});
      }
      filter.propagate(increment);
      const Vec3 noise{random_(), random_(), random_()};
      const SO3<double> R_v = world_ * orientation(t_ + wrong_.time_offset_s) * SO3<double>::exp(wrong_.turned) *
                              SO3<double>::exp(2e-4 * noise);
      filter.update(R_v, 4e-8 * Mat<double, 3, 3>::Identity(), rate - bias_);
    }
  }
  void leave_world() { world_ = SO3<double>::exp(Vec3(0.4, -1, 2)) * world_; }
  void jump() { bias_ += Vec3(0.3, -0.2, 0.1); }

 private:
  static constexpr double h = 1e-4;

  SO3<double> orientation(double t) const {
    return SO3<double>::exp(activity_ * Vec3(0.5 * std::sin(2.1 * t), 0.4 * std::sin(1.3 * t + 1), 0.6 * std::sin(t)));
  }
  Vec3 gyro(double t) const { return (orientation(t - h).inverse() * orientation(t + h)).log() / (2 * h) + bias_; }

  Wrong wrong_;
  double activity_, t_ = 0, integrated_ = 0, in_force_s_ = 0;
  Vec3 bias_ = Vec3(0.02, -0.05, 0.08);
  SO3<double> world_ = SO3<double>::exp(Vec3(1, 0.2, -0.7));
  testing::Gaussian random_{7};
};

}  // namespace

TEMPLATE_TEST_CASE("camera_imu_filter: estimates the time offset to a millisecond", "", float, double) {
  for (const double offset_s : {0.015, -0.015, 0.05, -0.05}) {
    CAPTURE(offset_s);
    CameraImuFilter filter(CameraImuOptions{});
    Body body({offset_s});
    body.run<TestType>(filter, 20);
    CAPTURE(body.time_offset_s(), filter.time_offset_error(), filter.time_offset_sigma());
    REQUIRE(std::abs(body.time_offset_s() + filter.time_offset_error() - offset_s) < 1e-3);
    REQUIRE(std::abs(body.time_offset_s() - offset_s) < 2e-3);
    REQUIRE(filter.time_offset_sigma() < 1e-3);
  }
}

TEST_CASE("camera_imu_filter: a time offset corrected by the window is not corrected twice") {
  CameraImuFilter filter(CameraImuOptions{});
  Body body({0.015});
  body.shift_time_offset(filter, 0.015);
  body.run<double>(filter, 20);
  CAPTURE(body.time_offset_s());
  REQUIRE(std::abs(body.time_offset_s() - 0.015) < 1e-3);
  body.shift_time_offset(filter, -0.015);  // they give it up
  body.run<double>(filter, 1);
  REQUIRE(std::abs(body.time_offset_s() - 0.015) < 1.5e-3);
}

TEST_CASE("camera_imu_filter: a calibration that is right stays as it is") {
  CameraImuFilter filter(CameraImuOptions{});
  Body body({});
  body.run<double>(filter, 5);
  REQUIRE(filter.accepts_time_offset(3e-3));
  body.run<double>(filter, 55);
  REQUIRE(body.time_offset_s() == 0);
  REQUIRE(filter.rotation_error().norm() < 3 * filter.rotation_sigma());
}

TEST_CASE("camera_imu_filter: estimates the rotation of the extrinsics") {
  const Vec3 turned(0.02, -0.03, 0.01);
  CameraImuFilter filter(CameraImuOptions{});
  Body body({0, turned});
  body.run<double>(filter, 40);
  CAPTURE(filter.rotation_error().transpose(), filter.rotation_sigma());
  // Vision has the body R_bc' R_bc^T of where it is.
  REQUIRE((filter.rotation_error() - turned).norm() < 0.006);
  REQUIRE(body.time_offset_s() == 0);
  filter.rotate_extrinsics(turned);  // from now on it is known
  REQUIRE(filter.rotation_error().norm() < 0.006);
}

TEST_CASE("camera_imu_filter: is consistent after a reset, a bias jump, and without rotation") {
  CameraImuFilter filter(CameraImuOptions{});
  Body body({0.015});
  body.run<double>(filter, 10);
  body.leave_world();
  filter.reset_world();
  body.run<double>(filter, 5);
  body.jump();
  body.run<double>(filter, 10);
  REQUIRE(std::abs(body.time_offset_s() - 0.015) < 2e-3);

  CameraImuFilter nothing(CameraImuOptions{});
  Body still({0.015}, 0);
  still.run<double>(nothing, 20);
  REQUIRE(still.time_offset_s() == 0);
  REQUIRE(nothing.time_offset_sigma() > 0.03);
}

TEST_CASE("camera_imu_filter: the correction of the time offset is limited") {
  CameraImuOptions options;
  options.max_correction_s = 0.03;
  CameraImuFilter filter(options);
  Body body({0.05});
  body.run<double>(filter, 20);
  REQUIRE(body.time_offset_s() == 0.03);
}

TEST_CASE("camera_imu_filter: a calibrated value is not estimated") {
  CameraImuOptions options;
  options.time_offset_sigma_s = options.rotation_sigma = 0;
  CameraImuFilter filter(options);
  Body body({0.015, Vec3(0.03, 0, 0)});
  body.run<double>(filter, 20);
  REQUIRE(filter.time_offset_error() == 0);
  REQUIRE(filter.rotation_error().norm() == 0);
  REQUIRE(filter.accepts_time_offset(1e-9));
}
