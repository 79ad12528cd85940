#include "plumbline/residual/relative_sim3.hpp"

#include "plumbline/residual/relative_pose.hpp"
#include "residual/relative_pose_suite.hpp"

using namespace plumbline;

namespace {
const auto make = [](const SO3<double>& R, const Vec<double, 3>& p, double s) { return Sim3<double>(s, R, p); };
}

TEMPLATE_TEST_CASE("relative_sim3: value, Jacobians, transport", "", float, double) {
  using S = TestType;
  test::check_relative_pose<RelativeSim3Residual, S>(make, std::is_same_v<S, float> ? 2e-5 : 1e-8);
}

TEST_CASE("relative_sim3: of poses with scale 1 it is the residual of poses") {
  testing::Gaussian normal(2);
  for (int k = 0; k < 20; ++k) {
    const auto random = [&] { return SE3<double>(SO3<double>::exp(normal.vector<3>()), normal.vector<3>()); };
    const SE3<double> T_i = random(), T_j = random(), measured = random();
    const auto poses = RelativePoseResidual<double>{measured}.linearize(T_i, T_j);
    const auto similarities =
        RelativeSim3Residual<double>{Sim3<double>(measured)}.linearize(Sim3<double>(T_i), Sim3<double>(T_j));
    REQUIRE((similarities.r.head<6>() - poses.r).norm() < 1e-12);
    REQUIRE(std::abs(similarities.r[6]) < 1e-15);
    REQUIRE((similarities.J_r_i.topLeftCorner<6, 6>() - poses.J_r_i).norm() < 1e-12);
    REQUIRE((similarities.J_r_j.topLeftCorner<6, 6>() - poses.J_r_j).norm() < 1e-12);
  }
}
