#include "plumbline/factor/zero_velocity.hpp"

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

TEST_CASE("zero_velocity: whitened motion and velocity, the Jacobians, and half the square as cost") {
  const ZeroVelocityFactor<double> factor{0.1, 0.02, 0.04};
  testing::Gaussian noise(3);
  for (int k = 0; k < 10; ++k) {
    const NavState<double> x_i = test::random_state(noise), x_j = test::random_state(noise);
    const auto at = [&](const NavState<double>& i, const NavState<double>& j) { return factor.linearize(i, i, j, j); };
    const auto rows = at(x_i, x_j);
    const Vec<double, 6> d = minus(x_j.T_world_body, x_i.T_world_body);
    CHECK((rows.r.head<3>() - d.head<3>() / 0.02).norm() < 1e-9);
    CHECK((rows.r.segment<3>(3) - d.tail<3>() / 0.04).norm() < 1e-9);
    CHECK((rows.r.tail<3>() - x_j.v_world_body / 0.1).norm() < 1e-9);
    CHECK(testing::jacobian_error(
              rows.J_i, [&](const auto& x) { return at(x, x_j).r; }, x_i) < 1e-5);
    CHECK(testing::jacobian_error(
              rows.J_j, [&](const auto& x) { return at(x_i, x).r; }, x_j) < 1e-5);
    double cost = 2;
    factor.add_cost(x_i, x_j, cost);
    CHECK(cost == Approx(2 + rows.r.squaredNorm() / 2));
  }
}

TEST_CASE("zero_velocity: nothing at rest") {
  const ZeroVelocityFactor<float> factor{0.1, 0.02, 0.04};
  NavState<float> x;
  x.T_world_body = SE3<float>(SO3<float>::exp({0.1f, 0.2f, 0.3f}), Vec<float, 3>(1, 2, 3));
  CHECK(factor.linearize(x, x, x, x).r.norm() == 0);
}
