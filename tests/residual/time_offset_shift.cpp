#include "plumbline/residual/time_offset_shift.hpp"

#include <type_traits>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("time_offset_shift: rows are pulled back as the state is moved", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-8, step = 1e-6;
  testing::Gaussian noise(1);
  for (int n = 0; n < 60; ++n) {
    const NavState<double> x = test::random_state(noise);
    const TimeOffsetShift<double> shift{n % 3 == 0 ? 0 : n % 3 == 1 ? 0.05 : -0.015, noise.vector<3>()};
    const NavState<double> at = shift(x);
    Mat<S, 15, 15> J = Mat<S, 15, 15>::Identity();
    const TimeOffsetShift<S> same{S(shift.delay), shift.gyro.cast<S>()};
    const Vec<double, 15> by_delay = same.pull_back(x.cast<S>(), J).template cast<double>();
    for (int k = 0; k < 15; ++k) {
      const Vec<double, 15> d = step * Vec<double, 15>::Unit(k);
      const Vec<double, 15> numeric =
          (minus(shift(plus(x, d)), at) - minus(shift(plus(x, Vec<double, 15>(-d))), at)) / (2 * step);
      CAPTURE(n, k);
      CHECK((J.col(k).template cast<double>() - numeric).norm() < tolerance * (1 + numeric.norm()));
    }
    TimeOffsetShift<double> later = shift, sooner = shift;
    later.delay += step;
    sooner.delay -= step;
    const Vec<double, 15> numeric = (minus(later(x), at) - minus(sooner(x), at)) / (2 * step);
    CHECK((by_delay - numeric).norm() < tolerance * (1 + numeric.norm()));
  }
}

TEMPLATE_TEST_CASE("time_offset_shift: no delay changes nothing, to the bit", "", float, double) {
  using S = TestType;
  testing::Gaussian noise(2);
  const NavState<S> x = test::random_state(noise).cast<S>();
  const TimeOffsetShift<S> none{S(0), noise.vector<3>().template cast<S>()};
  REQUIRE(minus(none(x), x).norm() == 0);
  Mat<S, 15, 15> J = Mat<S, 15, 15>::Random();
  const Mat<S, 15, 15> before = J;
  none.pull_back(x, J);
  REQUIRE(J == before);
}

TEST_CASE("time_offset_shift: a body that turns and moves evenly is where it was") {
  testing::Gaussian noise(3);
  NavState<double> x = test::random_state(noise);
  const Vec<double, 3> w = noise.vector<3>();
  const TimeOffsetShift<double> shift{0.04, w + x.bias_gyro};
  const NavState<double> before = shift(x);
  CHECK((before.T_world_body.rotation().inverse() * x.T_world_body.rotation()).log().isApprox(0.04 * w, 1e-12));
  CHECK((before.T_world_body.p() + 0.04 * x.v_world_body).isApprox(x.T_world_body.p(), 1e-12));
  CHECK(before.v_world_body == x.v_world_body);
}
