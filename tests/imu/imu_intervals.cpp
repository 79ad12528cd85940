#include "plumbline/imu/imu_intervals.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "imu/random_motion.hpp"

using namespace plumbline;

namespace {

/// Of 5 ms each.
template <class S, std::size_t Capacity>
ImuIntervals<S, Capacity> intervals(const test::RandomMotion& motion, int count, int first = 0) {
  constexpr TimeNs dt_ns = 5'000'000;
  ImuIntervals<S, Capacity> out;
  test::for_each_interval(motion, first * dt_ns, (first + count) * dt_ns, count,
                          [&](const ImuInterval<double>& interval) { REQUIRE(out.add(interval.cast<S>())); });
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("imu_intervals: when full, pairs are merged, and later ones up to their length", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(1);
  const test::RandomMotion motion(normal);
  CHECK(intervals<S, 8>(motion, 8).size() == 8);
  const auto nine = intervals<S, 8>(motion, 9);
  REQUIRE(nine.size() == 5);  // four of 10 ms, one of 5 ms
  for (std::size_t k = 0; k < 4; ++k) CHECK(double(nine[k].dt) == Approx(0.01));
  CHECK(double(nine.back().dt) == Approx(0.005));
  for (int count = 1; count < 200; ++count) {
    const auto many = intervals<S, 8>(motion, count);
    S sum = 0, longest = 0;
    for (const ImuInterval<S>& interval : many) {
      sum += interval.dt;
      longest = std::max(longest, interval.dt);
    }
    REQUIRE(double(sum) == Approx(0.005 * count).epsilon(1e-5));
    REQUIRE(double(many.duration()) == Approx(0.005 * count).epsilon(1e-5));
    REQUIRE(double(longest) < 0.005 * 2.01 * std::max(1.0, count / 8.0));
  }
}

TEST_CASE("imu_intervals: appended ones are those added one by one") {
  testing::Gaussian normal(2);
  const test::RandomMotion motion(normal);
  auto parts = intervals<double, 8>(motion, 11);
  parts.append(intervals<double, 16>(motion, 9, 11));
  const auto whole = intervals<double, 8>(motion, 20);
  REQUIRE(parts.size() == whole.size());
  CHECK(parts.duration() == Approx(whole.duration()));
  for (std::size_t k = 0; k < whole.size(); ++k) {
    CHECK((parts[k].gyro_begin - whole[k].gyro_begin).norm() < 1e-12);
    CHECK((parts[k].accel_end - whole[k].accel_end).norm() < 1e-12);
  }
}

TEST_CASE("imu_intervals: noise is added to each, a duration of zero or NaN is refused") {
  testing::Gaussian normal(3);
  auto some = intervals<double, 8>(test::RandomMotion(normal), 4);
  some.inflate_accelerometer_noise(20);
  for (const auto& interval : some) CHECK(interval.accel_sigma.y() * std::sqrt(interval.dt) == Approx(20));
  ImuIntervals<double, 8> none;
  CHECK_FALSE(none.add({0, {0, 0, 0}, {0, 0, 0}, {0, 0, 9}, {0, 0, 9}}));
  CHECK_FALSE(none.add({std::numeric_limits<double>::quiet_NaN(), {0, 0, 0}, {0, 0, 0}, {0, 0, 9}, {0, 0, 9}}));
  CHECK((none.empty() && none.duration() == 0));
}
