#include "plumbline/imu/interval.hpp"

#include <cmath>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/imu/increment.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("interval: merging keeps a steady trend exactly, and adds errors in squares", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-13;
  testing::Gaussian normal(1);
  for (int i = 0; i < 20; ++i) {
    const Vec<S, 3> w = normal.vector<3>().cast<S>(), slope = S(normal()) * w;  // axis fixed
    const S t1 = S(0.1 + normal.random().uniform()), t2 = t1 + S(0.1 + normal.random().uniform());
    const Vec<S, 3> w1 = w + t1 * slope, w2 = w + t2 * slope;
    const ImuInterval<S> a{t1, w, w1, 2 * w, 2 * w1, S(0.3), {0, 0, 2}},
        b{t2 - t1, w1, w2, 2 * w1, 2 * w2, S(0.4), {1, 0, 0}};
    const ImuInterval<S> c = merged(a, b);
    REQUIRE(std::abs(c.dt - t2) < S(tolerance));
    REQUIRE((c.gyro_begin - w).norm() + (c.gyro_end - w2).norm() < 10 * tolerance);
    REQUIRE((c.accel_begin - 2 * w).norm() + (c.accel_end - 2 * w2).norm() < 20 * tolerance);
    // errors of the two are independent: sigma of the integral, dt sigma, adds in squares
    REQUIRE(c.dt * c.gyro_sigma == Approx(std::hypot(a.dt * S(0.3), b.dt * S(0.4))).epsilon(1e-5));
    REQUIRE((c.dt * c.accel_sigma - Vec<S, 3>(b.dt, 0, 2 * a.dt)).norm() < S(tolerance));
  }
}

TEST_CASE("interval: merging keeps rotation and velocity, to second order in the angle") {
  testing::Gaussian normal(2);
  for (int i = 0; i < 20; ++i) {
    const Vec<double, 3> w1 = normal.vector<3>(), w2 = normal.vector<3>();
    const Vec<double, 3> a1 = normal.vector<3>(), a2 = normal.vector<3>();
    for (const double dt : {0.02, 0.04}) {
      ImuIncrement<double> apart, together;
      const ImuInterval<double> first{dt, w1, w1, a1, a1}, second{0.7 * dt, w2, w2, a2, a2};
      apart.integrate(first, {});
      apart.integrate(second, {});
      together.integrate(merged(first, second), {});
      const double angle = dt * (w1.norm() + w2.norm());
      REQUIRE(minus(together.delta.dR, apart.delta.dR).norm() < 0.5 * std::pow(angle, 3));
      REQUIRE((together.delta.dv - apart.delta.dv).norm() < dt * (a1.norm() + a2.norm()) * angle * angle);
    }
  }
}
