#include "plumbline/residual/relative_pose_yaw.hpp"

#include "plumbline/residual/relative_pose.hpp"
#include "residual/relative_pose_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("relative_pose_yaw: value, Jacobians, transport", "", float, double) {
  using S = TestType;
  const auto make = [](const SO3<double>& R, const Vec<double, 3>& p, double) { return SE3<double>(R, p); };
  test::check_relative_pose<RelativePoseYawResidual, S>(make, std::is_same_v<S, float> ? 2e-5 : 1e-8);
}

TEST_CASE("relative_pose_yaw: the heading is exactly linear, without gimbal lock") {
  using Residual = RelativePoseYawResidual<double>;
  testing::Gaussian normal(3);
  for (int k = 0; k < 100; ++k) {
    // pitch of 90 degrees is an attitude like any other
    const SO3<double> R_i = SO3<double>::exp({0, k % 3 == 0 ? std::numbers::pi / 2 : normal(), 0});
    const SE3<double> T_i(R_i, normal.vector<3>()), T_j(SO3<double>::exp(normal.vector<3>()), normal.vector<3>());
    const Residual residual{T_i.inverse() * T_j};
    Vec<double, 4> d_i = Vec<double, 4>::Zero(), d_j = d_i;
    d_i[0] = normal();
    d_j[0] = d_i[0] + 3 * (normal.random().uniform() - 0.5);
    const double r = residual.residual(Residual::moved(T_i, d_i), Residual::moved(T_j, d_j))[0];
    REQUIRE(r == Approx(d_j[0] - d_i[0]).margin(1e-12));
  }
}

TEST_CASE("relative_pose_yaw: an increment leaves roll and pitch") {
  testing::Gaussian normal(4);
  SE3<double> T(SO3<double>::exp(normal.vector<3>()), normal.vector<3>());
  const Vec<double, 3> vertical = T.rotation().inverse() * Vec<double, 3>(0, 0, 1);
  for (int k = 0; k < 1000; ++k) T = RelativePoseYawResidual<double>::moved(T, normal.vector<4>());
  REQUIRE((T.rotation().inverse() * Vec<double, 3>(0, 0, 1) - vertical).norm() < 1e-12);
}

TEST_CASE("relative_pose_yaw: increment, Jacobians and transport are those of poses, restricted") {
  testing::Gaussian normal(5);
  for (int k = 0; k < 20; ++k) {
    const auto random = [&] { return SE3<double>(SO3<double>::exp(normal.vector<3>()), normal.vector<3>()); };
    const SE3<double> T_j = random(), T_k = random();
    const Mat<double, 4, 6> to_yaw_j = RelativePoseYawResidual<double>::from_pose_increment(T_j),
                            to_yaw_k = RelativePoseYawResidual<double>::from_pose_increment(T_k);
    const Mat<double, 6, 4> from_yaw_j = to_yaw_j.transpose();  // dphi = R^T e3 dpsi
    REQUIRE((to_yaw_j * from_yaw_j - Mat<double, 4, 4>::Identity()).norm() < 1e-12);
    const Vec<double, 4> d = 1e-5 * normal.vector<4>();
    REQUIRE((minus(RelativePoseYawResidual<double>::moved(T_j, d), T_j) - from_yaw_j * d).norm() < 1e-9);
    const Mat<double, 4, 4> A = to_yaw_k * RelativePoseResidual<double>::transport(T_j, T_k) * from_yaw_j;
    REQUIRE((RelativePoseYawResidual<double>::transport(T_j, T_k) - A).norm() < 1e-12);
  }
}

TEST_CASE("relative_pose_yaw: no heading where the vertical is upside down") {
  const SE3<double> level, upside_down(SO3<double>::exp({std::numbers::pi, 0, 0}), Vec<double, 3>(1, 2, 3));
  REQUIRE(!RelativePoseYawResidual<double>{level}.linearize(level, upside_down).valid);
  REQUIRE(RelativePoseYawResidual<double>{upside_down}.linearize(level, upside_down).valid);
}
