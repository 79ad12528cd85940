#include "plumbline/imu/preintegration.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "imu/random_motion.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs one_second = 1'000'000'000;

template <class S>
void require_equal(const ImuIncrement<S>& a, const ImuIncrement<S>& b, double tolerance) {
  REQUIRE(minus(a.delta.dR, b.delta.dR).norm() < tolerance);
  REQUIRE((a.delta.dp - b.delta.dp).norm() < tolerance);
  REQUIRE((a.delta.dv - b.delta.dv).norm() < tolerance);
  REQUIRE((a.J_delta_bias - b.J_delta_bias).norm() < 10 * tolerance);
  REQUIRE((a.covariance - b.covariance).norm() <= tolerance * b.covariance.norm());
}

template <class S, std::size_t Capacity = 256>
Preintegration<S, Capacity> preintegrated(const test::RandomMotion& motion, TimeNs begin, TimeNs end,
                                          const Vec<S, 3>& bias_gyro = Vec<S, 3>::Zero(),
                                          const Vec<S, 3>& bias_accel = Vec<S, 3>::Zero()) {
  Preintegration<S, Capacity> out(ImuNoise{}, bias_gyro, bias_accel);
  test::for_each_interval(motion, begin, end, int((end - begin) / 5'000'000),
                          [&](const ImuInterval<double>& d) { REQUIRE(out.add(d.cast<S>())); });
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("preintegration: again about other biases is as if from the start", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(1);
  const test::RandomMotion motion(normal);
  const Vec<S, 3> bg(S(0.03), S(-0.05), S(0.02)), ba(S(0.2), S(0.1), S(-0.3));
  Preintegration<S, 256> p = preintegrated<S>(motion, 0, one_second);
  REQUIRE(p.increment().is_far(bg));
  p.reintegrate(bg, ba);
  REQUIRE(!p.increment().is_far(bg));
  require_equal(p.increment(), preintegrated<S>(motion, 0, one_second, bg, ba).increment(), 1e-15);
  REQUIRE((p.increment().bias_gyro == bg && p.increment().bias_accel == ba));
}

TEMPLATE_TEST_CASE("preintegration: one appended to another is the whole", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(2);
  const test::RandomMotion motion(normal);
  Preintegration<S, 256> p = preintegrated<S>(motion, 0, one_second / 4);
  p.append(preintegrated<S>(motion, one_second / 4, one_second, Vec<S, 3>(S(0.1), S(0), S(0))));
  require_equal(p.increment(), preintegrated<S>(motion, 0, one_second).increment(),
                std::is_same_v<S, float> ? 1e-5 : 1e-13);
  REQUIRE(p.intervals().size() == 200);
}

TEMPLATE_TEST_CASE("preintegration: when full, twice the step and the same motion", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(3);
  for (int i = 0; i < 10; ++i) {
    const test::RandomMotion motion(normal);
    Preintegration<S, 128> small = preintegrated<S, 128>(motion, 0, one_second);
    const Preintegration<S, 256> large = preintegrated<S>(motion, 0, one_second);
    require_equal(small.increment(), large.increment(), 1e-15);  // not touched by the merging
    REQUIRE((small.intervals().size() >= 64 && small.intervals().size() <= 128));
    S duration = 0;
    for (const ImuInterval<S>& interval : small.intervals()) duration += interval.dt;
    REQUIRE(duration == Approx(1).epsilon(1e-5));
    small.reintegrate(Vec<S, 3>::Zero(), Vec<S, 3>::Zero());  // in steps of up to 20 ms, of 8 m/s^2 at 3 Hz
    REQUIRE(minus(small.increment().delta.dR, large.increment().delta.dR).norm() < S(5e-4));
    REQUIRE((small.increment().delta.dv - large.increment().delta.dv).norm() < S(3e-2));
    REQUIRE((small.increment().delta.dp - large.increment().delta.dp).norm() < S(5e-2));
    const double sigma_ratio = double(small.increment().covariance(6, 6)) / double(large.increment().covariance(6, 6));
    REQUIRE(sigma_ratio == Approx(1).epsilon(0.1));
  }
}

// The oldest samples must not be merged each time that there is no more room: they would become one step of seconds.
TEMPLATE_TEST_CASE("preintegration: steps of a long one are all alike", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(5);
  for (int i = 0; i < 10; ++i) {
    const test::RandomMotion motion(normal);
    for (const int seconds : {2, 3, 5}) {
      Preintegration<S, 128> small = preintegrated<S, 128>(motion, 0, seconds * one_second);
      const ImuIncrement<S> exact = small.increment();
      S shortest = S(1), longest = S(0), duration = S(0);
      for (const ImuInterval<S>& interval : small.intervals()) {
        duration += interval.dt;
        longest = std::max(longest, interval.dt);
        if (&interval != &small.intervals().back()) shortest = std::min(shortest, interval.dt);
      }
      CAPTURE(seconds, small.intervals().size(), shortest, longest);
      REQUIRE(double(duration) == Approx(seconds).epsilon(1e-4));
      REQUIRE(longest < S(1.1) * shortest);
      REQUIRE(double(longest) < 2.1 * seconds / 128);
      small.reintegrate(Vec<S, 3>::Zero(), Vec<S, 3>::Zero());
      // In steps of up to 40 ms, of 8 m/s^2 at 3 Hz.
      REQUIRE(minus(small.increment().delta.dR, exact.delta.dR).norm() < S(1e-4));
      REQUIRE((small.increment().delta.dv - exact.delta.dv).norm() < S(5e-2));
      REQUIRE((small.increment().delta.dp - exact.delta.dp).norm() < S(0.15));
    }
  }
}

TEMPLATE_TEST_CASE("preintegration: a suspect accelerometer inflates the velocity and changes nothing else", "", float,
                   double) {
  using S = TestType;
  testing::Gaussian normal(3);
  const test::RandomMotion motion(normal);
  Preintegration<S, 256> p = preintegrated<S>(motion, 0, one_second);
  const ImuIncrement<S> sure = p.increment();
  ImuIntervals<S, 256> suspect = p.intervals();
  suspect.inflate_accelerometer_noise(S(20));
  const ImuIncrement<S> inflated = integrated(suspect, p.noise(), zeros<S, 3>(), zeros<S, 3>());
  REQUIRE((inflated.delta.dv == sure.delta.dv && inflated.delta.dp == sure.delta.dp));
  REQUIRE(minus(inflated.delta.dR, sure.delta.dR).norm() == 0);
  for (int k = 0; k < 3; ++k) {
    CHECK(inflated.covariance(k, k) == sure.covariance(k, k));
    CHECK(double(std::sqrt(inflated.covariance(6 + k, 6 + k))) == Approx(20).epsilon(0.01));
    CHECK(double(std::sqrt(inflated.covariance(3 + k, 3 + k))) == Approx(20 / std::sqrt(3.0)).epsilon(0.01));
  }
}

TEST_CASE("preintegration: when a new bias is far") {
  testing::Gaussian normal(4);
  const test::RandomMotion motion(normal);
  const Preintegration<double, 256> p = preintegrated<double>(motion, 0, one_second / 2);
  REQUIRE(!p.increment().is_far(Vec<double, 3>(1e-4, 0, 0)));
  REQUIRE(p.increment().is_far(Vec<double, 3>(0.0201, 0, 0)));  // 0.01 rad in half a second
  REQUIRE(p.increment().is_far(Vec<double, 3>(0, std::numeric_limits<double>::quiet_NaN(), 0)));
}

TEST_CASE("preintegration: refuses intervals without duration") {
  Preintegration<double> p;
  ImuInterval<double> interval{0, {0, 0, 0}, {0, 0, 0}, {0, 0, 9}, {0, 0, 9}};
  REQUIRE(!p.add(interval));
  interval.dt = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(!p.add(interval));
  interval.dt = -0.01;
  REQUIRE(!p.add(interval));
  REQUIRE((p.empty() && p.increment().duration == 0));
}
