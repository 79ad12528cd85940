#include "plumbline/lie/so3.hpp"

#include <cmath>
#include <limits>

#include "group_laws.hpp"

using namespace plumbline;
using testing::random_angle;
using testing::random_tangent;

TEMPLATE_TEST_CASE("so3: group laws", "", float, double) { testing::check_group_laws<SO3<TestType>>(); }

TEMPLATE_TEST_CASE("so3: coefficients against long double", "", float, double) {
  using S = TestType;
  long double worst = 0;
  for (double exponent = -8; exponent < 0.491; exponent += 1e-3) {  // 1e-8 .. 3.1 rad
    const S t = S(std::pow(10, 2 * exponent));
    const long double q = t, th = std::sqrt(q), h = th / 2;
    const RotationCoefficients<S> c = RotationCoefficients<S>::at(t);
    // The closed forms lose digits even in long double: below 0.3 rad more terms of the series.
    long double B = 2 * std::sin(h) * std::sin(h) / q, C = (th - std::sin(th)) / (q * th),
                D = 1 / q - 1 / std::tan(h) / (2 * th);
    if (q < 0.1L) {
      long double term = 1;
      B = C = 0;
      for (int n = 0; n < 10; ++n) {  // term = (-q)^n / (2n)!
        B += term / ((2 * n + 1) * (2 * n + 2));
        C += term / ((2 * n + 1) * (2 * n + 2) * (2 * n + 3));
        term *= -q / ((2 * n + 1) * (2 * n + 2));
      }
      D = 1.0L / 12 +
          q * (1.0L / 720 +
               q * (1.0L / 30240 + q * (1.0L / 1209600 + q * (1.0L / 47900160 + q * (691.0L / 1307674368000)))));
    }
    const long double A = std::sin(th) / th;
    for (const auto& [ours, exact] : {std::pair<long double, long double>{c.A, A}, {c.B, B}, {c.C, C}, {c.D, D}}) {
      worst = std::max(worst, std::abs(ours - exact) / std::abs(exact));
    }
  }
  CAPTURE(double(worst));
  CHECK(double(worst) < (std::is_same_v<S, float> ? 3e-6 : 5e-13));
}

TEMPLATE_TEST_CASE("so3: left and right Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 3e-6 : 1e-10;
  Random random(3);
  for (int turn = 0; turn < 300; ++turn) {
    const Vec<S, 3> phi = random_tangent<SO3<S>>(random, random_angle(random, turn));
    const Vec<double, 3> exact = phi.template cast<double>();
    const Mat<S, 3, 3> Jr = SO3<S>::right_jacobian(phi), Jl = SO3<S>::left_jacobian(phi);
    const SO3<double> R = SO3<double>::exp(exact);
    CHECK(testing::jacobian_error(
              Jr, [&](const Vec<double, 3>& x) { return minus(SO3<double>::exp(x), R); }, exact) < tolerance);
    CHECK((SO3<S>::right_jacobian_inverse(phi) * Jr - Mat<S, 3, 3>::Identity()).norm() < S(tolerance));
    CHECK((SO3<S>::left_jacobian_inverse(phi) * Jl - Mat<S, 3, 3>::Identity()).norm() < S(tolerance));
    CHECK((SO3<S>::exp(phi).matrix() * Jr - Jl).norm() < S(tolerance));
    CHECK((SO3<S>::exp(phi).matrix() * hat(phi) - hat(phi) * SO3<S>::exp(phi).matrix()).norm() < S(tolerance));
  }
}

TEMPLATE_TEST_CASE("so3: agrees with the rotation matrix", "", float, double) {
  using S = TestType;
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  CHECK((SO3<S>::exp({0, 0, S(1.5707963267948966)}) * Vec<S, 3>(1, 0, 0) - Vec<S, 3>(0, 1, 0)).norm() < tolerance);
  Random random(4);
  for (int turn = 0; turn < 300; ++turn) {
    const SO3<S> R = SO3<S>::exp(random_tangent<SO3<S>>(random, random_angle(random, turn)));
    const Mat<S, 3, 3> M = R.matrix();
    CHECK((M * M.transpose() - Mat<S, 3, 3>::Identity()).norm() < 4 * tolerance);
    CHECK(testing::distance(SO3<S>::from_matrix(M), R) < 8 * tolerance);
    CHECK((R * Vec<S, 3>(1, 2, 3) - M * Vec<S, 3>(1, 2, 3)).norm() < 8 * tolerance);
    CHECK(R.quaternion().w() >= 0);
  }
}

TEMPLATE_TEST_CASE("so3: a million products stay rotations", "", float, double) {
  using S = TestType;
  SO3<S> R, back;
  const SO3<S> step = SO3<S>::exp(Vec<S, 3>(S(0.7), S(-0.3), S(1.1))), step_back = step.inverse();
  for (int i = 0; i < 1000000; ++i) {
    R = R * step;
    back = step_back * back;
  }
  CHECK(std::abs(R.quaternion().norm() - 1) < 4 * std::numeric_limits<S>::epsilon());
  CHECK(testing::distance(R * back, SO3<S>()) < 1000 * std::sqrt(S(1000000)) * std::numeric_limits<S>::epsilon());
}

TEMPLATE_TEST_CASE("so3: NaN stays NaN", "", float, double) {
  using S = TestType;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  CHECK(!SO3<S>::exp({0, nan, 0}).quaternion().coeffs().allFinite());
  CHECK(!SO3<S>::exp({0, nan, 0}).log().allFinite());
}
