#include "plumbline_ros2/odometry.hpp"

#include "catch.hpp"
#include "message_like.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using namespace plumbline::ros2;

namespace {

SE3<double> pose(double a, double b, double c, double x, double y, double z) {
  return {SO3<double>::exp(Vec<double, 3>(a, b, c)), Vec<double, 3>(x, y, z)};
}
const SE3<double> T_world_body = pose(0.4, -0.7, 1.9, 3, -2, 1), T_base_body = pose(1.2, 0.3, -0.5, 0.2, -0.1, 0.4);

}  // namespace

TEST_CASE("the base is at the origin of odom when a camera without an IMU begins, with REP 103 axes") {
  const BaseFrame base(default_T_base_body(false), false);
  REQUIRE(minus(base.T_odom_base({}), SE3<double>()).norm() < 1e-12);
  const SE3<double> forward(SO3<double>(), Vec<double, 3>(0, 0, 2));  // the camera moves along its axis
  REQUIRE((base.T_odom_base(forward).p() - Vec<double, 3>(2, 0, 0)).norm() < 1e-12);
  const SE3<double> right(SO3<double>(), Vec<double, 3>(1, 0, 0));
  REQUIRE((base.T_odom_base(right).p() - Vec<double, 3>(0, -1, 0)).norm() < 1e-12);
}

TEST_CASE("with an IMU odom is the world, and the base is where the extrinsics put it") {
  const BaseFrame base(T_base_body, true);
  REQUIRE(minus(base.T_odom_base(T_world_body) * T_base_body, T_world_body).norm() < 1e-12);
  REQUIRE(minus(default_T_base_body(true), SE3<double>()).norm() == 0);
}

TEST_CASE("the covariance has the order and the axes of nav_msgs") {
  for (const bool has_gravity : {true, false}) {
    const BaseFrame base(T_base_body, has_gravity);
    const SE3<double> T_odom_base = base.T_odom_base(T_world_body);
    // Position, and rotation about the fixed axes of odom.
    const auto error = [&](const SE3<double>& T) {
      const SE3<double> moved = base.T_odom_base(T);
      Vec<double, 6> out;
      out << moved.p() - T_odom_base.p(), (moved.rotation() * T_odom_base.rotation().inverse()).log();
      return out;
    };
    const Mat<double, 6, 6> J = testing::numeric_jacobian<6, 6>(error, T_world_body);
    Mat<double, 6, 6> A = Mat<double, 6, 6>::Zero();
    for (int i = 0; i < 36; ++i) A(i / 6, i % 6) = (i * 7 % 11) - 5;
    const Mat<double, 6, 6> covariance = A * A.transpose(), expected = J * covariance * J.transpose();
    REQUIRE((covariance_in_odom(base, T_world_body, covariance) - expected).norm() < 1e-7 * expected.norm());
  }
  // One that can be read: uncertain in heading alone, seen from above, with the body upright and turned.
  Mat<double, 6, 6> heading = Mat<double, 6, 6>::Zero();
  heading(2, 2) = 0.01;
  const BaseFrame base({}, true);
  const Mat<double, 6, 6> out = covariance_in_odom(base, pose(0, 0, 1, 5, 6, 7), heading);
  REQUIRE(out(5, 5) == Approx(0.01));
  REQUIRE(out.topLeftCorner<5, 5>().norm() < 1e-15);
}

TEST_CASE("the twist of the base is the derivative of its pose, in its own axes") {
  const BaseFrame base(T_base_body, true);
  const Vec<double, 3> v(0.5, -1, 2), w(0.3, 0.2, -0.9);
  const double h = 1e-6;
  const auto after = [&](double t) {
    return SE3<double>(T_world_body.rotation() * SO3<double>::exp(t * w), T_world_body.p() + t * v);
  };
  const SE3<double> before = base.T_odom_base(after(-h)), now = base.T_odom_base(after(h));
  const Twist twist = twist_of(base, T_world_body, v, w), mean = mean_twist(before, now, 2 * h);
  REQUIRE((twist.angular - mean.angular).norm() < 1e-6);
  REQUIRE((twist.linear - mean.linear).norm() < 1e-5);
}

TEST_CASE("messages have what an odometry has") {
  Odometry odometry;
  odometry.T_odom_base = T_world_body;
  for (int i = 0; i < 36; ++i) odometry.covariance(i / 6, i % 6) = i;
  odometry.twist = {{1, 2, 3}, {4, 5, 6}};
  message_like::Odometry message;
  set_odometry(odometry, message);
  REQUIRE(message.pose.pose.position.y == -2);
  REQUIRE(message.pose.covariance[6 * 1 + 4] == 10);
  REQUIRE(message.twist.twist.linear.z == 3);
  REQUIRE(message.twist.twist.angular.x == 4);
  REQUIRE(message.twist.covariance == std::array<double, 36>{});
  message_like::Transform transform;
  set_transform(T_world_body, transform);
  const message_like::Quaternion& q = transform.rotation;
  const SE3<double> back(SO3<double>(Eigen::Quaterniond(q.w, q.x, q.y, q.z)),
                         {transform.translation.x, transform.translation.y, transform.translation.z});
  REQUIRE(minus(back, T_world_body).norm() < 1e-12);
}
