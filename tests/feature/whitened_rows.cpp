#include "plumbline/feature/whitened_rows.hpp"

#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE_SIG("whitened_rows: residual and Jacobian are multiplied with the whitening", "",
                       ((class S, int Rows), S, Rows), (float, 1), (double, 1), (float, 2), (double, 2)) {
  const Mat<S, Rows, Rows> W = Mat<S, Rows, Rows>::Random();
  const Vec<S, Rows> r = Vec<S, Rows>::Random();
  const Mat<S, Rows, 6> J = Mat<S, Rows, 6>::Random();
  const auto rows = WhitenedRows<S, Rows>::of(W, r, J);
  const S tolerance = std::is_same_v<S, float> ? S(1e-6) : S(1e-14);
  REQUIRE(rows.valid);
  REQUIRE((rows.r - W * r).norm() < tolerance);
  REQUIRE((rows.J - W * J).norm() < tolerance);
  REQUIRE_FALSE(WhitenedRows<S, Rows>{}.valid);
}
