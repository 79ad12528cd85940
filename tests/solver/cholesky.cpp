#include "plumbline/solver/cholesky.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <limits>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("cholesky: solves a damped system from its lower triangle", "", float, double) {
  using S = TestType;
  Random random(1);
  for (const int dim : {1, 2, 7, 30}) {
    const Eigen::MatrixXd J = random_matrix(random, 2 * dim, dim);
    Eigen::MatrixXd A = J.transpose() * J;
    const Eigen::VectorXd damping = Eigen::VectorXd::LinSpaced(dim, 0, 1), b = random_matrix(random, dim, 1);
    const Eigen::VectorXd expected = (A + Eigen::MatrixXd(damping.asDiagonal())).inverse() * b;
    A.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());  // not read
    Cholesky<S, 30> factor;
    REQUIRE(factor.compute(A.cast<S>().eval(), damping.cast<S>()));
    typename Cholesky<S, 30>::Vector x = b.cast<S>();
    factor.solve_in_place(x);
    REQUIRE((x.template cast<double>() - expected).norm() < (sizeof(S) == 4 ? 1e-3 : 1e-11) * expected.norm());
  }
}

TEMPLATE_TEST_CASE("cholesky: refuses what is not positive definite or not finite", "", float, double) {
  using S = TestType;
  Random random(2);
  Cholesky<S, 12> factor;
  const Eigen::MatrixXd J = random_matrix(random, 11, 12);
  const Mat<S, 12, 12> singular = (J.transpose() * J).cast<S>();  // rounding decides the sign of the last pivot
  REQUIRE_FALSE(factor.compute(singular, Vec<S, 12>::Zero()));
  REQUIRE(factor.compute(singular, Vec<S, 12>::Constant(S(1e-2))));
  Eigen::Matrix<S, 3, 3> A = Eigen::Matrix<S, 3, 3>::Identity();
  A(2, 2) = S(-1);
  REQUIRE_FALSE(factor.compute(A, Vec<S, 3>::Zero()));
  A(2, 2) = std::numeric_limits<S>::quiet_NaN();
  REQUIRE_FALSE(factor.compute(A, Vec<S, 3>::Zero()));
  A(2, 2) = std::numeric_limits<S>::infinity();
  REQUIRE_FALSE(factor.compute(A, Vec<S, 3>::Zero()));
  A(2, 2) = S(0);
  REQUIRE_FALSE(factor.compute(A, Vec<S, 3>::Zero()));
}

TEMPLATE_TEST_CASE("cholesky: rows that start late, in another order", "", float, double) {
  using S = TestType;
  constexpr int dim = 22;
  Random random(3);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3 * dim, dim);  // a chain, closed by the last three parameters
  for (int k = 0; k < dim; ++k) {
    for (int n = 0; n < 3; ++n) {
      J(3 * k + n, k) = 2 + random.uniform();
      if (k > 0) J(3 * k + n, k - 1) = random.uniform();
      J(3 * k + n, dim - 1 - n) += random.uniform();
    }
  }
  const Eigen::MatrixXd A = J.transpose() * J;
  const Eigen::VectorXd b = random_matrix(random, dim, 1), expected = A.inverse() * b;
  const auto shuffled = [](int k) { return (5 * k + 2) % dim; };
  Eigen::MatrixXd stored(dim, dim);  // such that the order of the factor is that of the chain
  const Eigen::VectorXd unit = Eigen::VectorXd::Unit(dim, 9);
  for (int i = 0; i < dim; ++i) {
    for (int j = 0; j < dim; ++j) stored(shuffled(i), shuffled(j)) = A(i, j);
  }
  Cholesky<S, 30> factor;
  REQUIRE(factor.compute(stored.cast<S>().eval(), Vec<S, dim>::Zero(), shuffled));
  Vec<S, dim> solution = b.cast<S>(), forward = unit.cast<S>();
  factor.solve_in_place(solution);
  REQUIRE((solution.template cast<double>() - expected).norm() < (sizeof(S) == 4 ? 1e-4 : 1e-12) * expected.norm());
  factor.forward_in_place(forward, 9);
  REQUIRE(double(forward.squaredNorm()) == Approx(A.inverse()(9, 9)).epsilon(sizeof(S) == 4 ? 1e-4 : 1e-12));
}
