#include "plumbline/solver/gauss_newton.hpp"

#include <Eigen/LU>
#include <limits>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("gauss_newton: weighted rows and their solution", "", float, double) {
  using S = TestType;
  const double tolerance = sizeof(S) == 4 ? 1e-4 : 1e-12;
  Random random(1);
  DenseNormalEquations<S, 4> normal;
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(4, 4);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(4);
  Vec<S, 4> d;
  REQUIRE_FALSE(normal.solve(d));  // nothing measured
  for (int k = 0; k < 20; ++k) {
    const Mat<S, 2, 4> J = random_matrix<S, 2, 4>(random);
    const Vec<S, 2> r = random_matrix<S, 2, 1>(random);
    const S w = S(random.uniform());
    normal.add(J, r, w);
    normal.add_cost(S(2));
    H += double(w) * (J.transpose() * J).template cast<double>();
    b += double(w) * (J.transpose() * r).template cast<double>();
  }
  REQUIRE(normal.cost() == S(20));
  REQUIRE(normal.solve(d));
  const Eigen::VectorXd expected = -H.inverse() * b;
  REQUIRE(relative_error(d.template cast<double>(), expected) < tolerance);
  Mat<S, 4, 4> covariance;
  REQUIRE(normal.covariance(covariance));
  REQUIRE(relative_error(covariance.template cast<double>(), H.inverse()) < tolerance);
  REQUIRE(normal.solve(d, S(0.5)));
  const Eigen::VectorXd damped = -(H + Eigen::MatrixXd(0.5 * H.diagonal().asDiagonal())).inverse() * b;
  REQUIRE(relative_error(d.template cast<double>(), damped) < tolerance);
  normal.add(Mat<S, 1, 4>(Mat<S, 1, 4>::Constant(std::numeric_limits<S>::quiet_NaN())), Vec<S, 1>(S(1)), S(1));
  REQUIRE_FALSE(normal.solve(d));
  REQUIRE_FALSE(normal.covariance(covariance));
}

TEMPLATE_TEST_CASE("gauss_newton: finds a pose from points", "", float, double) {
  using S = TestType;
  Random random(2);
  const SE3<S> truth = plus(SE3<S>(), random_matrix<S, 6, 1>(random));
  SE3<S> T;
  for (int iteration = 0; iteration < 8; ++iteration) {
    DenseNormalEquations<double, 6> normal;
    Random points(3);
    for (int k = 0; k < 10; ++k) {  // r = T x - y, dr/dphi = -R hat(x), dr/dp = R
      const Vec<S, 3> x = random_matrix<S, 3, 1>(points), y = truth * x;
      Mat<S, 3, 6> J;
      J << -T.R() * hat(x), T.R();
      normal.add(J, Vec<S, 3>(T * x - y), 1.0);
    }
    Vec<double, 6> d;
    REQUIRE(normal.solve(d));
    T = plus(T, Vec<S, 6>(d.cast<S>()));
  }
  REQUIRE(minus(T, truth).norm() < (sizeof(S) == 4 ? 1e-5 : 1e-13));
}

TEMPLATE_TEST_CASE("gauss_newton: equations of the first parameters alone", "", float, double) {
  using S = TestType;
  Random random(2);
  DenseNormalEquations<S, 5> whole, expected;
  DenseNormalEquations<S, 3> leading;
  for (int k = 0; k < 10; ++k) {
    const Mat<S, 2, 3> J = random_matrix<S, 2, 3>(random);
    const Vec<S, 2> r = random_matrix<S, 2, 1>(random);
    leading.add(J, r, S(0.5));
    leading.add_cost(S(1));
    Mat<S, 2, 5> wide = Mat<S, 2, 5>::Zero();
    set_block(wide, 0, 0, J);
    expected.add(wide, r, S(0.5));
  }
  whole.add(leading);
  REQUIRE(whole.cost() == leading.cost());
  REQUIRE((whole.H() - expected.H()).norm() < S(1e-5));
  REQUIRE((whole.b() - expected.b()).norm() < S(1e-5));
}

TEMPLATE_TEST_CASE("gauss_newton: linear rows at a state that has moved", "", float, double) {
  using S = TestType;
  Random random(4);
  DenseNormalEquations<S, 4> moved, expected;
  const Vec<S, 4> d = random_matrix<S, 4, 1>(random);
  for (int k = 0; k < 10; ++k) {
    const Mat<S, 2, 4> J = random_matrix<S, 2, 4>(random);
    const Vec<S, 2> r = random_matrix<S, 2, 1>(random);
    moved.add(J, r, S(0.5));
    expected.add(J, Vec<S, 2>(r + J * d), S(0.5));
  }
  moved.move(d);
  REQUIRE((moved.H() - expected.H()).norm() == 0);
  REQUIRE((moved.b() - expected.b()).norm() < S(1e-5));
}
