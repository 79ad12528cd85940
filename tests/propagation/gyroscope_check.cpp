#include "plumbline/propagation/gyroscope_check.hpp"

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

constexpr double dt = 0.05;

/// Frames that turn against the gyroscope by a rate, with noise, until its bias has jumped.
template <class S>
int until_jump(GyroscopeCheck<S>& check, const Vec<double, 3>& rate, double sigma_rad, int frames) {
  testing::Gaussian noise(1);
  for (int k = 0; k < frames; ++k) {
    check.advance(S(dt));
    const Vec<double, 3> turned = dt * rate + sigma_rad * Vec<double, 3>(noise(), noise(), noise());
    if (check.update(turned.cast<S>(), S(sigma_rad * sigma_rad), S(dt))) return k;
  }
  return frames;
}

}  // namespace

TEMPLATE_TEST_CASE("gyroscope_check: a bias jump is first suspected, then detected once", "", float, double) {
  using S = TestType;
  const GyroscopeCheckOptions options;
  GyroscopeCheck<S> check(options);
  const Vec<double, 3> jump(0.06, -0.05, 0.06);
  REQUIRE(until_jump(check, Vec<double, 3>::Zero(), 3e-4, 1000) == 1000);
  CHECK_FALSE(check.is_suspect());
  const int frames = until_jump(check, jump, 3e-4, 20);
  CHECK(frames * dt < options.rate_error_s);
  CHECK(check.is_suspect());
  CHECK(jump.dot(check.rate_error().template cast<double>()) > 0.25 * jump.squaredNorm());

  const double turned = jump.norm() * (frames + 1) * dt;
  CHECK(double(check.gyro_jump_rotation()) > turned);
  CHECK(double(check.gyro_jump_rotation()) < 3 * turned);

  CHECK_FALSE(check.has_recent_jump());
  check.reset_after_jump();
  CHECK(check.gyro_jump_rotation() == 0);
  CHECK(check.has_recent_jump());
  CHECK(check.rate_error().norm() == 0);
  CHECK(until_jump(check, jump, 3e-4, 200) * dt == Approx(options.jump_hold_s).margin(1.5 * dt));
}

TEMPLATE_TEST_CASE("gyroscope_check: uncertain image rotations detect no jump", "", float, double) {
  GyroscopeCheck<TestType> check(GyroscopeCheckOptions{});
  CHECK(until_jump(check, Vec<double, 3>(0.1, 0, 0), 1e-2, 1000) == 1000);
}
