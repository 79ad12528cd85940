#include "plumbline/imu/increment.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs half_second = 500'000'000;

/// Over half a second at 200 Hz.
template <class S>
ImuIncrement<S> increment_of(const test::RandomMotion& motion, const Vec<double, 3>& bias_gyro,
                             const Vec<double, 3>& bias_accel, const ImuNoise& noise = {}) {
  ImuIncrement<S> out(bias_gyro.cast<S>(), bias_accel.cast<S>());
  test::for_each_interval(motion, 0, half_second, 100,
                          [&](const ImuInterval<double>& d) { out.integrate(d.cast<S>(), noise); });
  return out;
}

template <class D>
Vec<double, 9> difference(const D& a, const D& b) {
  Vec<double, 9> d;
  d << minus(a.dR, b.dR).template cast<double>(), (a.dp - b.dp).template cast<double>(),
      (a.dv - b.dv).template cast<double>();
  return d;
}

}  // namespace

TEMPLATE_TEST_CASE("increment: predicts what midpoint integration in the world gives", "", float, double) {
  using S = TestType;
  const Vec<double, 3> gravity(0, 0, -9.81);
  testing::Gaussian normal(1);
  for (int i = 0; i < 20; ++i) {
    const test::RandomMotion motion(normal);
    const NavState<double> start = test::random_state(normal);
    NavState<double> x = start;
    test::for_each_interval(motion, 0, half_second, 100, [&](const ImuInterval<double>& d) {
      const SO3<double> R0 = x.T_world_body.rotation();
      const SO3<double> R1 = R0 * SO3<double>::exp(d.dt * (d.mean_gyro() - x.bias_gyro));
      const Vec<double, 3> a =
          0.5 * (R0 * Vec<double, 3>(d.accel_begin - x.bias_accel) + R1 * Vec<double, 3>(d.accel_end - x.bias_accel)) +
          gravity;
      x.T_world_body = SE3<double>(R1, x.T_world_body.p() + d.dt * x.v_world_body + 0.5 * d.dt * d.dt * a);
      x.v_world_body += d.dt * a;
    });
    const ImuIncrement<S> increment = increment_of<S>(motion, start.bias_gyro, start.bias_accel);
    const NavState<S> predicted = increment.predict(start.cast<S>(), gravity.cast<S>());
    REQUIRE(minus(predicted.template cast<double>(), x).norm() < (std::is_same_v<S, float> ? 2e-5 : 1e-13));
  }
}

TEMPLATE_TEST_CASE("increment: Jacobians by the biases", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(2);
  for (int i = 0; i < 10; ++i) {
    const test::RandomMotion motion(normal);
    Vec<double, 6> bias;
    bias << 0.05 * normal.vector<3>(), 0.3 * normal.vector<3>();
    const auto at = [&](const Vec<double, 6>& b) {
      return increment_of<double>(motion, b.head<3>(), b.tail<3>()).delta;
    };
    const auto reference = at(bias);
    const ImuIncrement<S> increment = increment_of<S>(motion, bias.head<3>(), bias.tail<3>());
    REQUIRE(testing::jacobian_error(
                increment.J_delta_bias, [&](const Vec<double, 6>& b) { return difference(at(b), reference); }, bias) <
            (std::is_same_v<S, float> ? 1e-5 : 1e-9));
    REQUIRE((increment.J_p_a() - increment.J_delta_bias.template block<3, 3>(3, 3)).norm() == 0);
  }
}

TEST_CASE("increment: first-order correction of the gyroscope bias, exact of the accelerometer bias") {
  testing::Gaussian normal(3);
  for (int i = 0; i < 20; ++i) {
    const test::RandomMotion motion(normal);
    const Vec<double, 3> bg = 0.05 * normal.vector<3>(), ba = 0.3 * normal.vector<3>();
    const ImuIncrement<double> increment = increment_of<double>(motion, bg, ba);
    const Vec<double, 3> new_ba = ba + normal.vector<3>();
    REQUIRE(difference(increment.corrected(bg, new_ba), increment_of<double>(motion, bg, new_ba).delta).norm() < 1e-13);
    double previous = 0;
    for (const double size : {0.01, 0.02}) {  // second order: a quarter of the error for half the step
      const Vec<double, 3> new_bg = bg + size * Vec<double, 3>(0.6, -0.48, 0.64);
      const double error =
          difference(increment.corrected(new_bg, ba), increment_of<double>(motion, new_bg, ba).delta).norm();
      REQUIRE(error < 5 * size * size);
      if (previous > 0) REQUIRE(error / previous == Approx(4).epsilon(0.1));
      previous = error;
    }
  }
}

TEST_CASE("increment: covariance is that of simulated noise, cross terms included") {
  const ImuNoise noise{.gyro_density = 2e-3, .accel_density = 2e-2, .gyro_walk = 5e-3, .accel_walk = 5e-2};
  testing::Gaussian normal(4);
  const test::RandomMotion motion(normal);
  const ImuIncrement<double> exact =
      increment_of<double>(motion, Vec<double, 3>::Zero(), Vec<double, 3>::Zero(), noise);
  const double root_dt = std::sqrt(0.005);
  Mat<double, 15, 15> sampled = Mat<double, 15, 15>::Zero();
  constexpr int runs = 4000;
  for (int i = 0; i < runs; ++i) {
    ImuIncrement<double> noisy;
    Vec<double, 6> bias = Vec<double, 6>::Zero();  // a white sample for each interval, biases that wander between them
    test::for_each_interval(motion, 0, half_second, 100, [&](ImuInterval<double> d) {
      const Vec<double, 3> w = bias.head<3>() + noise.gyro_density / root_dt * normal.vector<3>();
      const Vec<double, 3> a = bias.tail<3>() + noise.accel_density / root_dt * normal.vector<3>();
      d.gyro_begin -= w, d.gyro_end -= w, d.accel_begin -= a, d.accel_end -= a;
      noisy.integrate(d, noise);
      bias.head<3>() += noise.gyro_walk * root_dt * normal.vector<3>();
      bias.tail<3>() += noise.accel_walk * root_dt * normal.vector<3>();
    });
    Vec<double, 15> error;
    error << difference(noisy.delta, exact.delta), bias;
    sampled += error * error.transpose() / runs;
  }
  const Mat<double, 15, 15> L = *exact.square_root_information();
  const Mat<double, 15, 15> white = L * sampled * L.transpose();
  // each entry has a standard error of sqrt(1/runs) = 0.016, of the diagonal sqrt(2/runs) = 0.022
  REQUIRE((white - Mat<double, 15, 15>::Identity()).cwiseAbs().maxCoeff() < 0.1);
}

TEMPLATE_TEST_CASE("increment: square root of the information, from one interval on", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(5);
  for (const ImuNoise& noise : {ImuNoise{}, ImuNoise{0.01, 0.1, 1e-4, 1e-3, 200}, ImuNoise{0, 0, 0, 0, 200}}) {
    const test::RandomMotion motion(normal);
    ImuIncrement<S> increment;
    test::for_each_interval(motion, 0, half_second, 100, [&](const ImuInterval<double>& d) {
      increment.integrate(d.cast<S>(), noise);
      const Result<Mat<S, 15, 15>> L = increment.square_root_information();
      REQUIRE(L);
      Mat<double, 15, 15> floored = increment.covariance.template cast<double>();
      floored.diagonal().head<9>().array() += 1e-12;
      floored.diagonal().tail<6>().array() += 1e-14;
      const Mat<double, 15, 15> white = L->template cast<double>() * floored * L->template cast<double>().transpose();
      REQUIRE((white - Mat<double, 15, 15>::Identity()).norm() < (std::is_same_v<S, float> ? 0.05 : 1e-6));
    });
    increment.covariance(0, 0) = std::numeric_limits<S>::quiet_NaN();
    REQUIRE(increment.square_root_information().error() == Error::not_positive_definite);
  }
}

TEST_CASE("increment: the sigma of an interval counts as noise") {
  testing::Gaussian normal(6);
  const test::RandomMotion motion(normal);
  ImuInterval<double> d = test::interval_between(motion.at(0), motion.at(5'000'000));
  ImuIncrement<double> plain, inflated;
  plain.integrate(d, {});
  d.gyro_sigma = 0.4, d.accel_sigma = {2, 3, 4};
  inflated.integrate(d, {});
  REQUIRE(plain.covariance(0, 0) == Approx(1.7e-4 * 1.7e-4 * 0.005).epsilon(1e-3));
  REQUIRE(std::sqrt(inflated.covariance(0, 0)) == Approx(0.4 * 0.005).epsilon(1e-3));
  for (int k = 0; k < 3; ++k)
    REQUIRE(std::sqrt(inflated.covariance(6 + k, 6 + k)) == Approx(d.accel_sigma[k] * 0.005).epsilon(1e-2));
  REQUIRE(inflated.delta.dv == plain.delta.dv);
}
