#include "plumbline/motion/dead_reckoning.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/preintegration.hpp"

using namespace plumbline;

namespace {

constexpr double dt = 0.05, rate_z = 0.4, accel_x = 0.5;  // [s, rad/s, m/s^2]

/// The readings of a frame, whose body turns evenly about the vertical and gains speed along its own x.
template <class S>
ImuIncrement<S> frame() {
  Preintegration<S> readings(
      ImuNoise{.gyro_density = 1e-4, .accel_density = 1e-3, .gyro_walk = 1e-6, .accel_walk = 1e-5});
  const Vec<S, 3> gyro(S(0), S(0), S(rate_z)), accel(S(accel_x), S(0), standard_gravity<S>);
  for (int k = 0; k < 10; ++k) readings.add({S(dt / 10), gyro, gyro, accel, accel});
  return readings.increment();
}

template <class S>
struct Body {
  DeadReckoning<S> reckoning{DeadReckoningOptions{}};
  double t = 0;

  Body() {
    Mat<S, 6, 6> P = zeros<Mat<S, 6, 6>>();
    for (int k = 0; k < 6; ++k) P(k, k) = S(1e-6);
    reckoning.begin(NavState<S>{}, P, S(0.01));
  }
  void advance(double until_s, bool blind = false, bool missing = false) {
    for (; t < until_s - dt / 2; t += dt)
      reckoning.advance(frame<S>(), gravity_in_world<S>(standard_gravity<S>), S(dt), blind, missing);
  }
  double sigma(int k) const { return std::sqrt(double(reckoning.covariance()(k, k))); }
  double heading() const { return double(reckoning.state().T_world_body.rotation().log()[2]); }
  Vec<double, 3> p() const { return cast_to<double>(reckoning.state().T_world_body.p()); }
};

/// Where such a body is: the integral of v = a/w (sin wt, 1 - cos wt).
Vec<double, 3> truth(double t) {
  const double a = accel_x, w = rate_z;
  return {a / (w * w) * (1 - std::cos(w * t)), a / w * (t - std::sin(w * t) / w), 0};
}

}  // namespace

TEMPLATE_TEST_CASE("dead_reckoning: readings lead on, and their doubt grows", "", float, double) {
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
  CHECK_FALSE(body.reckoning.is_lost());
  CHECK(body.sigma(3) == Approx(DeadReckoningOptions{}.velocity_walk * std::sqrt(2.5)).epsilon(0.2));
}

TEMPLATE_TEST_CASE("dead_reckoning: after a while it stays where it is, and only turns", "", float, double) {
  Body<TestType> body;
  body.advance(2.9);
  const Vec<double, 3> p = body.p();
  body.advance(8);
  CHECK(body.reckoning.is_lost());
  CHECK(norm(Vec<double, 3>(body.p() - p)) < 0.2);
  CHECK(body.heading() == Approx(std::remainder(rate_z * 8, 2 * 3.14159265)).epsilon(1e-3));
  CHECK(body.sigma(3) > std::sqrt(8 * 8 - 3 * 3));
  CHECK(body.sigma(2) < 0.05);
  CHECK(body.reckoning.count_loss());
  CHECK_FALSE(body.reckoning.count_loss());
}

TEMPLATE_TEST_CASE("dead_reckoning: readings that do not tell", "", float, double) {
  Body<TestType> body;
  const bool missing = GENERATE(false, true);
  body.advance(1);
  body.advance(2, /*blind=*/true, missing);
  CHECK(body.reckoning.is_lost());
  CHECK(body.heading() == Approx(missing ? rate_z : 2 * rate_z).epsilon(1e-3));
  CHECK(body.sigma(3) > 1.7);
  CHECK((body.sigma(2) > 1.7) == missing);
}

TEST_CASE("dead_reckoning: a place far from where it leads is excluded while it leads") {
  Body<double> body;
  body.advance(1);
  const Vec<double, 3> away(0.5, 0, 0), there = body.p();
  CHECK(body.reckoning.outweighs(there + away, 0.1));
  CHECK_FALSE(body.reckoning.outweighs(there + away, 0.19));
  CHECK(body.reckoning.outweighs(Vec<double, 3>(std::nan(""), 0, 0), 0.19));
  body.advance(4);
  CHECK_FALSE(body.reckoning.outweighs(there + 20 * away, 0.1));
}

TEST_CASE("dead_reckoning: a place that is known worse than where it leads says nothing, before and after it is lost") {
  const DeadReckoning<double> nothing;
  CHECK_FALSE(nothing.outweighs({1, 0, 0}, 100));
  Body<double> body;
  for (const double s : {1.0, 4.0}) {
    body.advance(s);
    CAPTURE(s, body.reckoning.is_lost(), body.sigma(3));
    CHECK_FALSE(body.reckoning.outweighs(body.p(), 1.9 * body.sigma(3)));
    CHECK(body.reckoning.outweighs(body.p(), 2.1 * body.sigma(3)));
    CHECK(body.reckoning.outweighs(body.p(), std::nan("")));
  }
}

TEST_CASE("dead_reckoning: nothing before it has begun, and a loss that was counted by others") {
  DeadReckoning<double> reckoning;
  reckoning.advance(frame<double>(), {0, 0, -9.8}, dt, false, false);
  CHECK_FALSE(reckoning.has_begun());
  CHECK_FALSE(reckoning.is_lost());
  CHECK(max_abs(reckoning.covariance()) == 0);
  reckoning.begin(NavState<double>{}, identity<double, 6>(), 0);
  reckoning.lose();
  CHECK(reckoning.is_lost());
  CHECK_FALSE(reckoning.count_loss());
}
