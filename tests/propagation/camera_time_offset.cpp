#include "plumbline/propagation/camera_time_offset.hpp"

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

TEMPLATE_TEST_CASE("camera_time_offset: follows the estimate of the window in steps, and updates the filter", "", float,
                   double) {
  using S = TestType;
  CameraImuFilter filter(CameraImuOptions{});
  CameraTimeOffset<S> offset(0.01);
  const Vec<S, 3> w(S(0.1), S(0.2), S(-0.3));
  offset.set_gyro(w);
  offset.begin_factor();
  offset.calibrate(filter, Found{-0.013}, true, 0.01);
  CHECK(offset.offset_s() == Approx(0.0));
  CHECK(offset.previous().offset_s == 0.01);
  CHECK(offset.previous().gyro == w);
  CHECK(offset.keyframe().offset_s == 0.01);
  offset.calibrate(filter, Found{-0.013}, true, 0.01);
  offset.calibrate(filter, Found{-0.013}, true, 0.01);
  CHECK(offset.offset_s() == Approx(-0.013));
  CHECK(filter.time_offset_error() == Approx(0.023));
  offset.begin_factor_at_previous();
  CHECK(offset.keyframe().offset_s == offset.previous().offset_s);

  offset.reset_window_correction(filter);
  CHECK(offset.offset_s() == Approx(0.01));
  CHECK(filter.time_offset_error() == Approx(0).margin(1e-12));
}

TEST_CASE("camera_time_offset: without a window it is that of the filter, which is zero at first") {
  CameraImuFilter filter(CameraImuOptions{});
  CameraTimeOffset<double> offset(0.02);
  offset.calibrate(filter, Found{0.5}, false, 0.01);
  CHECK(offset.offset_s() == 0.02);
}

TEST_CASE("camera_time_offset: samples since the last frame begin at its sample boundary") {
  testing::Gaussian noise(1);
  const NavState<double> x = test::random_state(noise);
  CameraImuFilter filter(CameraImuOptions{});
  CameraTimeOffset<double> offset(0);
  offset.set_gyro(x.bias_gyro);
  offset.calibrate(filter, Found{0.004}, true, 0.01);
  const NavState<double> at_boundary = offset.at_boundary(x);
  CHECK((at_boundary.T_world_body.p() + 0.004 * x.v_world_body - x.T_world_body.p()).norm() < 1e-12);
  offset.calibrate(filter, Found{0.004}, true, 0.01);  // nothing new
  CHECK(minus(offset.at_boundary(x), x).norm() == 0);
}
