#include "plumbline/residual/relative_pose.hpp"

#include "residual/relative_pose_suite.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("relative_pose: value, Jacobians, transport", "", float, double) {
  using S = TestType;
  const auto make = [](const SO3<double>& R, const Vec<double, 3>& p, double) { return SE3<double>(R, p); };
  test::check_relative_pose<RelativePoseResidual, S>(make, std::is_same_v<S, float> ? 2e-5 : 1e-8);
}

TEST_CASE("relative_pose: the residual is minus(T_i_j, measured)") {
  testing::Gaussian normal(2);
  for (int k = 0; k < 20; ++k) {
    const auto random = [&] { return SE3<double>(SO3<double>::exp(normal.vector<3>()), normal.vector<3>()); };
    const SE3<double> T_i = random(), measured = random();
    const Vec<double, 6> d = 0.5 * normal.vector<6>();
    REQUIRE((RelativePoseResidual<double>{measured}.residual(T_i, T_i * plus(measured, d)) - d).norm() < 1e-12);
  }
}
