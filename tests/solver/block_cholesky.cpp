#include "plumbline/solver/block_cholesky.hpp"

#include <Eigen/LU>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("block_cholesky: every step", "", float, double) {
  using S = TestType;
  constexpr int N = 7, R = 5;
  const S tolerance = std::is_same_v<S, float> ? S(2e-4) : S(1e-11);
  Random random(4);
  for (int turn = 0; turn < 50; ++turn) {
    const Mat<S, N, N> J = random_matrix<S, N, N>(random);
    const Mat<S, N, N> A = J * J.transpose() + Mat<S, N, N>::Identity();
    Mat<S, N, N> L = A;
    REQUIRE(factorize_block(L, Vec<S, N>(A.diagonal())));
    const Mat<S, N, N> lower = L.template triangularView<Eigen::Lower>();
    REQUIRE((lower * lower.transpose() - A).norm() < tolerance);
    REQUIRE((inverse_of_factored(L) * A - Mat<S, N, N>::Identity()).norm() < tolerance);

    const Mat<S, R, N> X = random_matrix<S, R, N>(random);
    Mat<S, R, N> divided = X;
    divide_block(divided, L);
    REQUIRE((divided * lower.transpose() - X).norm() < tolerance);

    const Vec<S, N> y = random_matrix<S, N, 1>(random);
    Vec<S, N> solved = y;
    solve_lower(L, solved);
    REQUIRE((lower * solved - y).norm() < tolerance);
    solve_upper(L, solved);
    REQUIRE((A * solved - y).norm() < tolerance);

    const Mat<S, R, N> B = random_matrix<S, R, N>(random);
    Mat<S, R, R> C = random_matrix<S, R, R>(random);
    const Mat<S, R, R> minus_product = C - X * B.transpose();
    subtract_product(C, X, B);
    REQUIRE((C - minus_product).norm() < tolerance);
    Mat<S, N, N> G = A;
    add_transposed_product(G, X, B, S(2));
    REQUIRE((G - A - 2 * X.transpose() * B).norm() < tolerance);
    Vec<S, R> z = random_matrix<S, R, 1>(random);
    const Vec<S, R> z_before = z;
    subtract_product(z, X, y);
    REQUIRE((z - z_before + X * y).norm() < tolerance);
    Vec<S, N> w = y;
    subtract_transposed_product(w, X, z);
    REQUIRE((w - y + X.transpose() * z).norm() < tolerance);
  }
}

TEMPLATE_TEST_CASE("block_cholesky: what is not positive definite, or not finite", "", float, double) {
  using S = TestType;
  using Matrix = Mat<S, 3, 3>;
  const auto factorizes = [](Matrix A) { return factorize_block(A, Vec<S, 3>(A.diagonal())); };
  Matrix A = Matrix::Identity();
  REQUIRE(factorizes(A));
  A(2, 1) = 1;  // singular
  REQUIRE(!factorizes(A));
  A(2, 1) = 2;
  REQUIRE(!factorizes(A));
  for (const S number : {std::numeric_limits<S>::quiet_NaN(), std::numeric_limits<S>::infinity()}) {
    A = Matrix::Identity();
    A(1, 1) = number;
    REQUIRE(!factorizes(A));
    A = Matrix::Identity();
    A(1, 0) = number;
    REQUIRE(!factorizes(A));
  }
}
