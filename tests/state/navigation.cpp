#include "plumbline/state/navigation.hpp"

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("navigation: moving along the path inflates the covariance of a window, correcting does not", "",
                   float, double) {
  using S = TestType;
  const S calibration_error = S(0.01);
  Navigation<S, InertialLayout> navigation(WorldFrameUncertainty<S>(calibration_error, /*has_gravity=*/true));
  CHECK(navigation.covariance() == identity<S, 6>());
  navigation.move_to(SE3<S>({}, {S(3), S(4), S(0)}));
  navigation.set_window_covariance(zeros<S, 6, 6>());
  for (int k = 3; k < 6; ++k) CHECK(double(navigation.covariance()(k, k)) == Approx(0.05 * 0.05).epsilon(1e-4));
  navigation.set_pose(SE3<S>({}, {S(30), S(4), S(0)}));
  navigation.set_window_covariance(zeros<S, 6, 6>());
  for (int k = 3; k < 6; ++k) CHECK(double(navigation.covariance()(k, k)) == Approx(0.05 * 0.05).epsilon(1e-4));
}

TEST_CASE("navigation: velocity and biases follow only when they are set") {
  Navigation<double, InertialLayout> navigation(WorldFrameUncertainty<double>{});
  NavState<double> x;
  x.T_world_body = SE3<double>({}, {1, 2, 3});
  x.v_world_body = {4, 5, 6};
  x.bias_gyro = {0.1, 0, 0};
  x.bias_accel = {0, 0.2, 0};
  navigation.move_to(x.T_world_body);
  CHECK(navigation.T_world_body().p() == x.T_world_body.p());
  CHECK(navigation.state().v_world_body.isZero());
  navigation.set_motion(x);
  CHECK(navigation.state().v_world_body == x.v_world_body);
  CHECK(navigation.state().bias_accel == x.bias_accel);
  navigation.set_state({});
  CHECK(navigation.T_world_body().p().isZero());
  CHECK(navigation.state().bias_gyro.isZero());
}

TEST_CASE("navigation: variances are added on the diagonal, and the time is kept") {
  Navigation<double, VisualLayout> navigation(WorldFrameUncertainty<double>{});
  navigation.set_covariance(zeros<double, 6, 6>());
  navigation.add_variance(2, 3);
  const Mat<double, 6, 6> expected = Vec<double, 6>(2, 2, 2, 3, 3, 3).asDiagonal();
  CHECK(navigation.covariance() == expected);
  CHECK(navigation.t_ns() == 0);
  navigation.set_time(7);
  CHECK(navigation.t_ns() == 7);
}
