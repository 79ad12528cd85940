#include "plumbline/initialization/scale_verification.hpp"

#include <limits>

#include "catch.hpp"

using namespace plumbline;

namespace {

constexpr double dt = 0.05;

/// Frames up to that age [s], of a body as fast as that [m/s], whose IMU and images are inconsistent for as long.
ScaleVerification seen(double until_s, double speed, double sigma, double disagree_s = 0) {
  ScaleVerification verification(
      {.min_s = 3, .max_speed_sigma = 0.02, .speed_noise = 0.01, .max_slow_speed_sigma = 0.05});
  verification.begin();
  for (int k = 1; k * dt <= until_s + dt / 2; ++k)
    verification.update(k * dt, dt, k * dt < disagree_s + dt / 2, speed, sigma);
  return verification;
}

}  // namespace

TEST_CASE("scale_verification: converges after some time with a well determined speed") {
  CHECK_FALSE(seen(2.9, 1, 0.001).has_converged());
  CHECK(seen(3.1, 1, 0.019).has_converged());
  CHECK_FALSE(seen(30, 1, 0.021).has_converged());
  CHECK(seen(3.1, 0.3, 0.009).has_converged());  // 3 %, but what is left is not the scale's alone
  CHECK_FALSE(seen(30, 0.3, 0.011).has_converged());
  CHECK_FALSE(seen(30, 0.1, 0.006).has_converged());
  CHECK_FALSE(seen(30, 0, 0).has_converged());
  CHECK_FALSE(seen(30, 0, std::numeric_limits<double>::quiet_NaN()).has_converged());
  CHECK_FALSE(seen(30, std::numeric_limits<double>::quiet_NaN(), 0.001).has_converged());
}

TEST_CASE("scale_verification: once converged it stays so until a reset") {
  ScaleVerification verification = seen(3.1, 1, 0.019);
  verification.update(4, dt, false, 0.01, 0.1);
  CHECK(verification.has_converged());
  verification.update(4.1, 10, true, 1, 0.01);
  CHECK_FALSE(verification.is_rejected());  // an inconsistency after convergence is not that of the initialization
  verification.begin();
  CHECK_FALSE(verification.has_converged());
}

TEST_CASE("scale_verification: a long inconsistency before convergence rejects the initialization") {
  CHECK_FALSE(seen(3.1, 1, 0.1, 0.4).is_rejected());
  CHECK(seen(3.1, 1, 0.1, 0.6).is_rejected());
  ScaleVerification verification = seen(3.1, 1, 0.1, 0.4);
  verification.update(3.2, 10, true, 1, 0.1);  // too late
  CHECK_FALSE(verification.is_rejected());
  verification.update(1, 0.3, true, 1, 0.1);
  CHECK(verification.is_rejected());
  verification.begin();
  CHECK_FALSE(verification.is_rejected());
}
