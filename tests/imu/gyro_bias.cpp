#include "plumbline/imu/gyro_bias.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("gyro_bias: found exactly, preintegrations about it", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed < 10; ++seed) {
    const Vec<double, 3> bias(0.05, -0.1, 0.15);
    const test::SimulatedAlignment<S> s(seed, 1, bias, Vec<double, 3>::Zero());
    const GyroBias found = estimate_gyro_bias(s.span(), s.T_body_cam.rotation().template cast<S>(), 1e-3);
    REQUIRE(found.valid);
    REQUIRE((found.bias - bias).norm() < (std::is_same_v<S, float> ? 1e-5 : 1e-10));
    REQUIRE(found.residual < (std::is_same_v<S, float> ? 1e-5 : 1e-10));
    REQUIRE((s.imu[1].increment().bias_gyro.template cast<double>() - bias).norm() < 1e-5);
  }
}

TEST_CASE("gyro_bias: the residual shows wrong extrinsics, and nothing comes of nothing") {
  test::SimulatedAlignment<double> s(3, 1, Vec<double, 3>::Zero(), Vec<double, 3>::Zero());
  REQUIRE(estimate_gyro_bias(s.span(), SO3<double>(), 1e-3).residual > 0.05);
  REQUIRE(!estimate_gyro_bias(s.span().first(1), SO3<double>(), 1e-3).valid);
  s.frames[2].T_ref_cam = SE3<double>(SO3<double>::exp({std::nan(""), 0, 0}), {0, 0, 0});
  REQUIRE(!estimate_gyro_bias(s.span(), SO3<double>(), 1e-3).valid);
}
