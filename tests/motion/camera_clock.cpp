#include "plumbline/motion/camera_clock.hpp"

#include <cmath>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

struct Found {
  double offset_s;
  double time_offset_s(double) const { return offset_s; }
};

}  // namespace

TEMPLATE_TEST_CASE("camera_clock: the window is followed step by step, and the filter told", "", float, double) {
  using S = TestType;
  CameraImuFilter filter(CameraImuOptions{});
  CameraClock<S> clock(0.01);
  const Vec<S, 3> w(S(0.1), S(0.2), S(-0.3));
  clock.set_gyro(w);
  clock.begin_link();
  clock.calibrate(filter, Found{-0.013}, true, 0.01);
  CHECK(clock.offset_s() == Approx(0.0));
  CHECK(clock.previous().offset_s == 0.01);
  CHECK(clock.previous().gyro == w);
  CHECK(clock.keyframe().offset_s == 0.01);
  clock.calibrate(filter, Found{-0.013}, true, 0.01);
  clock.calibrate(filter, Found{-0.013}, true, 0.01);
  CHECK(clock.offset_s() == Approx(-0.013));
  CHECK(filter.time_offset_error() == Approx(0.023));
  clock.begin_link_before();
  CHECK(clock.keyframe().offset_s == clock.previous().offset_s);

  clock.forget_window(filter);
  CHECK(clock.offset_s() == Approx(0.01));
  CHECK(filter.time_offset_error() == Approx(0).margin(1e-12));
}

TEST_CASE("camera_clock: without a window the filter says it, which knows nothing yet") {
  CameraImuFilter filter(CameraImuOptions{});
  CameraClock<double> clock(0.02);
  clock.calibrate(filter, Found{0.5}, false, 0.01);
  CHECK(clock.offset_s() == 0.02);
}

TEST_CASE("camera_clock: readings since the last frame begin where it was cut") {
  testing::Gaussian noise(1);
  const NavState<double> x = test::random_state(noise);
  CameraImuFilter filter(CameraImuOptions{});
  CameraClock<double> clock(0);
  clock.set_gyro(x.bias_gyro);
  clock.calibrate(filter, Found{0.004}, true, 0.01);
  const NavState<double> at_cut = clock.at_cut(x);
  CHECK((at_cut.T_world_body.p() + 0.004 * x.v_world_body - x.T_world_body.p()).norm() < 1e-12);
  clock.calibrate(filter, Found{0.004}, true, 0.01);  // nothing new
  CHECK(minus(clock.at_cut(x), x).norm() == 0);
}
