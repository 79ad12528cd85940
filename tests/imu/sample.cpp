#include "plumbline/imu/sample.hpp"

#include <numbers>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/increment.hpp"

using namespace plumbline;

namespace {

/// The state after one second of the same sample, from rest at the origin.
NavState<double> after_a_second_of(const ImuSample& sample) {
  ImuIncrement<double> increment;
  for (int k = 0; k < 100; ++k) increment.integrate({0.01, sample.gyro, sample.gyro, sample.accel, sample.accel}, {});
  return increment.predict({}, gravity_in_world<double>());
}

}  // namespace

TEST_CASE("sample: a body whose sample is that of one stationary and level stays where it is") {
  const NavState<double> x = after_a_second_of({0, {0, 0, 0}, {0, 0, 9.81}});
  CHECK(norm(x.T_world_body.p()) < 1e-12);
  CHECK(norm(x.v_world_body) < 1e-12);
  CHECK(norm(after_a_second_of({}).v_world_body - Vec<double, 3>(0, 0, -9.81)) < 1e-12);  // zero: free fall
}

TEST_CASE("sample: a positive rate about z turns x to y, as seen in the body") {
  const double quarter = std::numbers::pi / 2;
  const NavState<double> x = after_a_second_of({0, {0, 0, quarter}, {0, 0, 9.81}});
  CHECK(norm(Vec<double, 3>(x.T_world_body.rotation() * Vec<double, 3>(1, 0, 0) - Vec<double, 3>(0, 1, 0))) < 1e-9);
}

TEST_CASE("sample: in double and to the nanosecond, whatever the scalar of the estimator") {
  ImuSample sample;
  CHECK((sample.t_ns == 0 && sample.gyro.isZero(0) && sample.accel.isZero(0)));
  sample.t_ns = 1'403'636'579'763'555'585;
  CHECK(sample.t_ns - 1'403'636'579'763'555'584 == 1);
  STATIC_REQUIRE(std::is_same_v<decltype(sample.gyro), Vec<double, 3>>);
}
