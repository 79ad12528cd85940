#include "plumbline/lie/sim3.hpp"

#include <Eigen/LU>

#include "group_laws.hpp"

using namespace plumbline;
using testing::random_angle;
using testing::random_tangent;

TEMPLATE_TEST_CASE("sim3: group laws", "", float, double) { testing::check_group_laws<Sim3<TestType>>(); }

TEMPLATE_TEST_CASE("sim3: exp is the matrix exponential", "", float, double) {
  using S = TestType;
  Random random(3);
  for (int turn = 0; turn < 300; ++turn) {
    Vec<double, 7> xi = random_tangent<Sim3<double>>(random, random_angle(random, turn));
    if (turn % 4 == 0) xi[6] *= 1e-7;
    Mat<double, 4, 4> X = Mat<double, 4, 4>::Zero(), E = Mat<double, 4, 4>::Identity();
    X.topLeftCorner<3, 3>() = hat(xi.head<3>()) + xi[6] * Mat<double, 3, 3>::Identity();
    X.topRightCorner<3, 1>() = xi.segment<3>(3);
    X /= 1024;
    for (int n = 12; n > 0; --n) E = (Mat<double, 4, 4>::Identity() + X * E / n).eval();
    for (int i = 0; i < 10; ++i) E = (E * E).eval();
    const Sim3<S> x = Sim3<S>::exp(xi.cast<S>());
    Mat<double, 4, 4> ours = Mat<double, 4, 4>::Identity();
    ours.topLeftCorner<3, 3>() = (x.scale() * x.R()).template cast<double>();
    ours.topRightCorner<3, 1>() = x.t().template cast<double>();
    CHECK((ours - E).norm() < (std::is_same_v<S, float> ? 1e-5 : 1e-11) * E.norm());
  }
}

TEMPLATE_TEST_CASE("sim3: scale one is se3", "", float, double) {
  using S = TestType;
  Random random(5);
  for (int turn = 0; turn < 100; ++turn) {
    Vec<S, 7> xi = random_tangent<Sim3<S>>(random, random_angle(random, turn));
    xi[6] = 0;
    const SE3<S> T = SE3<S>::exp(Vec<S, 6>(xi.template head<6>()));
    CHECK(testing::distance(Sim3<S>::exp(xi), Sim3<S>(T)) < (std::is_same_v<S, float> ? S(5e-6) : S(1e-13)));
  }
}

TEMPLATE_TEST_CASE("sim3: action and its Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-10;
  Random random(6);
  for (int turn = 0; turn < 100; ++turn) {
    const Sim3<S> X = Sim3<S>::exp(random_tangent<Sim3<S>>(random, random_angle(random, turn)));
    const Vec<S, 3> x = S(3) * testing::random_direction(random).cast<S>(), y = X.inverse() * x;
    const Vec<double, 3> exact_x = x.template cast<double>();
    Mat<S, 3, 7> J, J_inverse;
    J << -X.scale() * X.R() * hat(x), X.scale() * X.R(), X.scale() * X.R() * x;
    J_inverse << hat(y), -Mat<S, 3, 3>::Identity(), -y;
    const auto forward = [&](const Sim3<double>& P) -> Vec<double, 3> { return P * exact_x; };
    const auto backward = [&](const Sim3<double>& P) -> Vec<double, 3> { return P.inverse() * exact_x; };
    CHECK(testing::jacobian_error(J, forward, X.template cast<double>()) < tolerance);
    CHECK(testing::jacobian_error(J_inverse, backward, X.template cast<double>()) < tolerance);
  }
}
