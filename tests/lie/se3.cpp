#include "plumbline/lie/se3.hpp"

#include "group_laws.hpp"

using namespace plumbline;
using testing::random_angle;
using testing::random_tangent;

TEMPLATE_TEST_CASE("se3: group laws", "", float, double) { testing::check_group_laws<SE3<TestType>>(); }

TEMPLATE_TEST_CASE("se3: left and right Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-9;
  Random random(3);
  for (int turn = 0; turn < 300; ++turn) {
    const Vec<S, 6> xi = random_tangent<SE3<S>>(random, random_angle(random, turn));
    const Vec<double, 6> exact = xi.template cast<double>();
    const SE3<double> T = SE3<double>::exp(exact);
    // `minus` agrees with log(T^-1 .) to first order.
    const auto right = [&](const Vec<double, 6>& x) { return minus(SE3<double>::exp(x), T); };
    const auto left = [&](const Vec<double, 6>& x) { return (SE3<double>::exp(x) * T.inverse()).log(); };
    CHECK(testing::jacobian_error(SE3<S>::right_jacobian(xi), right, exact) < tolerance);
    CHECK(testing::jacobian_error(SE3<S>::left_jacobian(xi), left, exact) < tolerance);
    const Mat<S, 6, 6> I = Mat<S, 6, 6>::Identity();
    CHECK((SE3<S>::right_jacobian(xi) * SE3<S>::right_jacobian_inverse(xi) - I).norm() < S(tolerance));
    CHECK((SE3<S>::left_jacobian(xi) * SE3<S>::left_jacobian_inverse(xi) - I).norm() < S(tolerance));
  }
}

TEMPLATE_TEST_CASE("se3: Jacobians are continuous where the series ends", "", float, double) {
  using S = TestType;
  const S edge = std::sqrt(RotationCoefficients<S>::series_below);
  Random random(8);
  for (int i = 0; i < 100; ++i) {
    Vec<double, 6> exact = random_tangent<SE3<double>>(random, double(edge) * 0.9999);
    const Mat<double, 6, 6> below = SE3<S>::left_jacobian(exact.cast<S>()).template cast<double>();
    exact.head<3>() *= 1.0002;
    const Mat<double, 6, 6> above = SE3<S>::left_jacobian(exact.cast<S>()).template cast<double>();
    CHECK((below - above).norm() < 3e-4 * double(edge) * (1 + below.norm()));
    CHECK((above - SE3<double>::left_jacobian(exact)).norm() < (std::is_same_v<S, float> ? 3e-6 : 1e-12));
    CHECK((SE3<S>::left_jacobian((exact * 0.9998).cast<S>()).template cast<double>() -
           SE3<double>::left_jacobian(exact * 0.9998))
              .norm() < (std::is_same_v<S, float> ? 3e-6 : 1e-12));
  }
}

TEMPLATE_TEST_CASE("se3: action and its Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-10;
  Random random(6);
  for (int turn = 0; turn < 100; ++turn) {
    const SE3<S> T = SE3<S>::exp(random_tangent<SE3<S>>(random, random_angle(random, turn)));
    const Vec<S, 3> x = S(3) * testing::random_direction(random).cast<S>(), y = T.inverse() * x;
    const Vec<double, 3> exact_x = x.template cast<double>();
    CHECK((T * y - x).norm() < S(tolerance));
    Mat<S, 3, 6> J, J_inverse;  // what residuals build on
    J << -T.R() * hat(x), T.R();
    J_inverse << hat(y), -Mat<S, 3, 3>::Identity();
    const auto forward = [&](const SE3<double>& P) -> Vec<double, 3> { return P * exact_x; };
    const auto backward = [&](const SE3<double>& P) -> Vec<double, 3> { return P.inverse() * exact_x; };
    CHECK(testing::jacobian_error(J, forward, T.template cast<double>()) < tolerance);
    CHECK(testing::jacobian_error(J_inverse, backward, T.template cast<double>()) < tolerance);
  }
}
