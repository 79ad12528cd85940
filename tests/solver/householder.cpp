#include "plumbline/solver/householder.hpp"

#include <Eigen/LU>
#include <array>
#include <limits>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("householder: a reflection zeroes the tail and keeps lengths", "", float, double) {
  using S = TestType;
  const S tolerance = 20 * std::numeric_limits<S>::epsilon();
  Random random(1);
  for (int k = 0; k < 100; ++k) {
    Vec<S, 5> x = random_matrix<S, 5, 1>(random), y = random_matrix<S, 5, 1>(random);
    if (k % 3 == 0) x[0] = S(0);
    const Vec<S, 5> x0 = x, y0 = y;
    const S tau = make_reflection(x[0], &x[1], 4);
    reflect(tau, &x[1], y[0], &y[1], 4);
    REQUIRE(std::abs(std::abs(x[0]) - x0.norm()) < tolerance);
    REQUIRE(std::abs(y.norm() - y0.norm()) < tolerance);
    REQUIRE(std::abs(x[0] * y[0] - x0.dot(y0)) < tolerance);
  }
  Vec<S, 3> x(S(-2), S(0), S(0));
  REQUIRE(make_reflection(x[0], &x[1], 2) == S(0));
  REQUIRE(x[0] == S(-2));
}

TEST_CASE("householder: a few rows of several numbers are reflected as each of their columns") {
  Random random(5);
  const std::array<double, 2> v{0.5, -2};
  Vec<double, 3> first = random_matrix<double, 3, 1>(random);
  std::array<Vec<double, 3>, 2> rows{random_matrix<double, 3, 1>(random), random_matrix<double, 3, 1>(random)};
  const Vec<double, 3> first_before = first;
  const auto before = rows;
  reflect_few(0.3, v, first, rows);
  for (int c = 0; c < 3; ++c) {
    Vec<double, 3> column(first_before[c], before[0][c], before[1][c]);
    reflect(0.3, v.data(), column[0], &column[1], 2);
    REQUIRE((column - Vec<double, 3>(first[c], rows[0][c], rows[1][c])).norm() < 1e-15);
  }
}

TEST_CASE("householder: products and differences of any length") {
  const Eigen::VectorXd a = Eigen::VectorXd::LinSpaced(9, 1, 9), b = Eigen::VectorXd::LinSpaced(9, 3, 11);
  for (const int n : {0, 1, 3, 4, 7, 8}) {
    REQUIRE(dot(a.data(), b.data(), n) == a.head(n).dot(b.head(n)));
    Eigen::VectorXd difference = b;
    subtract_scaled(2.0, a.data(), difference.data(), n);
    REQUIRE(difference.head(n) == b.head(n) - 2 * a.head(n));
    REQUIRE(difference.tail(9 - n) == b.tail(9 - n));
  }
}

TEMPLATE_TEST_CASE("householder: two reflections in one pass are one after the other", "", float, double) {
  using S = TestType;
  constexpr int most = 9;
  const S tolerance = 20 * std::numeric_limits<S>::epsilon();
  Random random(4);
  for (int n = 0; n <= most; ++n) {
    using Tail = Vec<S, most>;
    Tail v = random_matrix<S, most, 1>(random), u = random_matrix<S, most, 1>(random);
    S pivot_v = S(0.7), pivot_u = S(-0.2);
    const S tau_v = make_reflection(pivot_v, v.data(), n), tau_u = make_reflection(pivot_u, u.data(), n);
    const Tail x = random_matrix<S, most, 1>(random);
    Tail one_by_one = x, twice = x;
    S first = S(0.3), second = S(0.9), first_expected = first, second_expected = second;
    reflect(tau_v, v.data(), first_expected, one_by_one.data(), n);
    reflect(tau_u, u.data(), second_expected, one_by_one.data(), n);
    reflect_twice(tau_v, v.data(), first, tau_u, u.data(), second, dot(v.data(), u.data(), n), twice.data(), n);
    REQUIRE(std::abs(first - first_expected) < tolerance);
    REQUIRE(std::abs(second - second_expected) < tolerance);
    REQUIRE((twice - one_by_one).norm() < tolerance);
  }
}

TEST_CASE("householder: eliminating columns leaves their Schur complement") {
  Random random(2);
  const Eigen::MatrixXd M = random_matrix(random, 20, 9);
  const int m = 4, r = 5;
  Eigen::MatrixXd work = M;
  REQUIRE(eliminate_leading_columns(work.data(), 20, m + r, 20, m) == m);
  const Eigen::MatrixXd J0 = work.block(m, m, 20 - m, r), Jm = M.leftCols(m), Jr = M.rightCols(r);
  const Eigen::MatrixXd schur =
      Jr.transpose() * Jr - Jr.transpose() * Jm * (Jm.transpose() * Jm).inverse() * Jm.transpose() * Jr;
  REQUIRE(work.block(m, 0, 20 - m, m).isZero(0));
  REQUIRE(relative_error(J0.transpose() * J0, schur) < 1e-12);
}

TEST_CASE("householder: a column without information has no pivot") {
  Random random(3);
  Eigen::MatrixXd M = random_matrix(random, 10, 6);
  M.col(0).setZero();
  M.col(2) = 2 * M.col(1);
  Eigen::MatrixXd work = M;
  const int rank = eliminate_leading_columns(work.data(), 10, 6, 10, 3);
  REQUIRE(rank == 1);
  const Eigen::VectorXd q = M.col(1).normalized();
  const Eigen::MatrixXd Jr = M.rightCols(3), projected = Jr - q * q.transpose() * Jr, J0 = work.block(1, 3, 9, 3);
  REQUIRE(relative_error(J0.transpose() * J0, projected.transpose() * projected) < 1e-12);
  work.setZero();
  REQUIRE(eliminate_leading_columns(work.data(), 10, 6, 10, 2) == 0);
}
