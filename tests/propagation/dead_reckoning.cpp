#include "plumbline/propagation/dead_reckoning.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/preintegration.hpp"

using namespace plumbline;

namespace {

constexpr double dt = 0.05, rate_z = 0.4, accel_x = 0.5;  // [s, rad/s, m/s^2]

/// The IMU samples of a frame whose body turns evenly about the vertical and gains speed along its own x.
template <class S>
ImuIncrement<S> frame() {
  Preintegration<S> samples(
      ImuNoise{.gyro_density = 1e-4, .accel_density = 1e-3, .gyro_walk = 1e-6, .accel_walk = 1e-5});
  const Vec<S, 3> gyro(S(0), S(0), S(rate_z)), accel(S(accel_x), S(0), standard_gravity<S>);
  for (int k = 0; k < 10; ++k) samples.add({S(dt / 10), gyro, gyro, accel, accel});
  return samples.increment();
}

template <class S>
struct Body {
  DeadReckoning<S> dead_reckoning{DeadReckoningOptions{}};
  double t = 0;

  Body() {
    Mat<S, 6, 6> P = zeros<Mat<S, 6, 6>>();
    for (int k = 0; k < 6; ++k) P(k, k) = S(1e-6);
    dead_reckoning.begin(NavState<S>{}, P, S(0.01));
  }
  void advance(double until_s, bool unusable = false, bool missing = false) {
    for (; t < until_s - dt / 2; t += dt)
      dead_reckoning.advance(frame<S>(), gravity_in_world<S>(standard_gravity<S>), S(dt), unusable, missing);
  }
  double sigma(int k) const { return std::sqrt(double(dead_reckoning.covariance()(k, k))); }
  double heading() const { return double(dead_reckoning.state().T_world_body.rotation().log()[2]); }
  Vec<double, 3> p() const { return cast_to<double>(dead_reckoning.state().T_world_body.p()); }
};

/// Where such a body is: the integral of v = a/w (sin wt, 1 - cos wt).
Vec<double, 3> truth(double t) {
  const double a = accel_x, w = rate_z;
  return {a / (w * w) * (1 - std::cos(w * t)), a / w * (t - std::sin(w * t) / w), 0};
}

}  // namespace

TEMPLATE_TEST_CASE("dead_reckoning: propagates by IMU samples, with a growing covariance", "", float, double) {
  Body<TestType> body;
  double before = body.sigma(3);
  for (double t = 0.5; t < 2.9; t += 0.5) {
    body.advance(t);
    CAPTURE(t, body.p(), truth(t));
    CHECK(norm(Vec<double, 3>(body.p() - truth(t))) < 2e-3);
    CHECK(body.heading() == Approx(rate_z * t).epsilon(1e-3));
    CHECK(body.sigma(3) > before);
    before = body.sigma(3);
  }
  CHECK_FALSE(body.dead_reckoning.is_lost());
  CHECK(body.sigma(3) == Approx(DeadReckoningOptions{}.velocity_walk * std::sqrt(2.5)).epsilon(0.2));
}

TEMPLATE_TEST_CASE("dead_reckoning: after the time limit the position is held and only the rotation is propagated", "",
                   float, double) {
  Body<TestType> body;
  body.advance(2.9);
  const Vec<double, 3> p = body.p();
  body.advance(8);
  CHECK(body.dead_reckoning.is_lost());
  CHECK(norm(Vec<double, 3>(body.p() - p)) < 0.2);
  CHECK(body.heading() == Approx(std::remainder(rate_z * 8, 2 * 3.14159265)).epsilon(1e-3));
  CHECK(body.sigma(3) > std::sqrt(8 * 8 - 3 * 3));
  CHECK(body.sigma(2) < 0.05);
  CHECK(body.dead_reckoning.count_loss());
  CHECK_FALSE(body.dead_reckoning.count_loss());
}

TEMPLATE_TEST_CASE("dead_reckoning: unusable IMU samples", "", float, double) {
  Body<TestType> body;
  const bool missing = GENERATE(false, true);
  body.advance(1);
  body.advance(2, /*unusable=*/true, missing);
  CHECK(body.dead_reckoning.is_lost());
  CHECK(body.heading() == Approx(missing ? rate_z : 2 * rate_z).epsilon(1e-3));
  CHECK(body.sigma(3) > 1.7);
  CHECK((body.sigma(2) > 1.7) == missing);
}

TEST_CASE("dead_reckoning: a position far from the propagated one is rejected until the propagation is lost") {
  Body<double> body;
  body.advance(1);
  const Vec<double, 3> away(0.5, 0, 0), there = body.p();
  CHECK(body.dead_reckoning.is_preferred_to(there + away, 0.1));
  CHECK_FALSE(body.dead_reckoning.is_preferred_to(there + away, 0.19));
  CHECK(body.dead_reckoning.is_preferred_to(Vec<double, 3>(std::nan(""), 0, 0), 0.19));
  body.advance(4);
  CHECK_FALSE(body.dead_reckoning.is_preferred_to(there + 20 * away, 0.1));
}

TEST_CASE("dead_reckoning: a position less certain than the propagated one is not preferred, before and after a loss") {
  const DeadReckoning<double> nothing;
  CHECK_FALSE(nothing.is_preferred_to({1, 0, 0}, 100));
  Body<double> body;
  for (const double s : {1.0, 4.0}) {
    body.advance(s);
    CAPTURE(s, body.dead_reckoning.is_lost(), body.sigma(3));
    CHECK_FALSE(body.dead_reckoning.is_preferred_to(body.p(), 1.9 * body.sigma(3)));
    CHECK(body.dead_reckoning.is_preferred_to(body.p(), 2.1 * body.sigma(3)));
    CHECK(body.dead_reckoning.is_preferred_to(body.p(), std::nan("")));
  }
}

TEST_CASE("dead_reckoning: no state before it begins, and a loss is counted once") {
  DeadReckoning<double> dead_reckoning;
  dead_reckoning.advance(frame<double>(), {0, 0, -9.8}, dt, false, false);
  CHECK_FALSE(dead_reckoning.has_begun());
  CHECK_FALSE(dead_reckoning.is_lost());
  CHECK(max_abs(dead_reckoning.covariance()) == 0);
  dead_reckoning.begin(NavState<double>{}, identity<double, 6>(), 0);
  dead_reckoning.mark_lost();
  CHECK(dead_reckoning.is_lost());
  CHECK_FALSE(dead_reckoning.count_loss());
}
