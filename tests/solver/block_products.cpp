#include "plumbline/solver/block_products.hpp"

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

template <class S, int N, std::size_t R>
void check() {
  Random random(1);
  const auto rows = [&] {
    std::array<Vec<S, N>, R> out;
    for (auto& row : out) row = random_matrix<S, N, 1>(random);
    return out;
  };
  const auto a = rows(), b = rows();
  const Mat<S, N, N> G = random_matrix<S, N, N>(random);
  Eigen::MatrixXd expected = G.template cast<double>(), expected_lower = expected;
  for (std::size_t k = 0; k < R; ++k) {
    expected += a[k].template cast<double>() * b[k].template cast<double>().transpose();
    expected_lower += a[k].template cast<double>() * a[k].template cast<double>().transpose();
  }
  const double tolerance = sizeof(S) == 4 ? 1e-6 : 1e-15;
  Mat<S, N, N> found = G;
  add_product(a, b, found);
  REQUIRE(relative_error(found.template cast<double>(), expected) < tolerance);
  const Mat<S, N, N> A = random_matrix<S, N, N>(random), B = random_matrix<S, N, N>(random);
  found = G;
  add_product(A, B, found);
  expected = G.template cast<double>() + A.template cast<double>() * B.template cast<double>();
  REQUIRE(relative_error(found.template cast<double>(), expected) < tolerance);
  found = G;
  add_lower_product(a, found);
  found = symmetric_block(found);
  REQUIRE(found == found.transpose());
  REQUIRE(relative_error(found.template cast<double>(), symmetric(expected_lower)) < tolerance);
}

}  // namespace

TEMPLATE_TEST_CASE("block_products: sums are those written out", "", float, double) {
  check<TestType, 6, 1>();
  check<TestType, 6, 4>();
  check<TestType, 3, 2>();
}
