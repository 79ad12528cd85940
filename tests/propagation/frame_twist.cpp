#include "plumbline/propagation/frame_twist.hpp"

#include "catch.hpp"
#include "propagation/steady_samples.hpp"

using namespace plumbline;

TEST_CASE("frame_twist: the angular rate at the end of the samples is extrapolated, and that before it kept") {
  // An angular rate that grows by 2 rad/s^2.
  test::SteadySamples<double> samples;
  samples.rate = [](double t) { return Vec<double, 3>(0, 0, 2 * t); };
  const Vec<double, 3> bias(0, 0, 0.01);
  FrameTwist<double> twist;
  samples.advance(0.1);
  twist.advance(samples.imu, bias, 0.1, 0.04);
  CHECK(twist.rate().z() == Approx(0.2 - bias.z()).epsilon(1e-6));  // a mean over 0.04 s would be 0.04 less
  samples.advance(0.1);
  twist.advance(samples.imu, bias, 0.1, 0.04);
  CHECK(twist.rate().z() == Approx(0.4 - bias.z()).epsilon(1e-6));
  CHECK(twist.rate_before().z() == Approx(0.2 - bias.z()).epsilon(1e-6));
}

TEST_CASE("frame_twist: before initialization the velocity is the mean of two intervals, in the axes of the frame") {
  struct View {
    SE3<double> T_world_previous;
    double dt;
  } const view{SE3<double>(), 0.5};
  NavState<double> predicted;
  predicted.v_world_body = {0, 2, 0};
  const SE3<double> T({}, {0, 2, 0});  // 4 m/s since the previous frame
  const SO3<double> R = SO3<double>::exp({0, 0, 1.5707963267948966});
  const Vec<double, 6> found = FrameTwist<double>::twist(predicted, T, view, R, {1, 2, 3});
  CHECK((found.head<3>() - Vec<double, 3>(1, 2, 3)).norm() == 0);
  CHECK((found.tail<3>() - Vec<double, 3>(3, 0, 0)).norm() < 1e-12);
}
