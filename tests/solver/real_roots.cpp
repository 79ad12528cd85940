#include "plumbline/solver/real_roots.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

/// c (x - roots[0]) ... (x - roots[N - 1])
template <class S, std::size_t N>
std::array<S, N + 1> expand(const std::array<S, N>& roots, S c) {
  std::array<S, N + 1> out{};
  out[0] = c;
  for (std::size_t degree = 0; degree < N; ++degree) {
    for (std::size_t k = degree + 1; k > 0; --k) out[k] = out[k - 1] - roots[degree] * out[k];
    out[0] *= -roots[degree];
  }
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("real_roots: those of a product of linear factors", "", float, double) {
  using S = TestType;
  Random random(2);
  for (int trial = 0; trial < 300; ++trial) {
    std::array<S, 5> roots;
    const S shift = S(0.2 * random.uniform());
    for (std::size_t k = 0; k < 5; ++k) roots[k] = S(-0.9) + S(0.4) * S(k) + shift * S(k % 2);  // apart
    const auto found = real_roots<5>(expand(roots, S(3) * (trial % 2 ? S(1) : S(-1))), S(-1), S(1));
    REQUIRE(found.size() == 5);
    for (std::size_t k = 0; k < 5; ++k) CHECK(std::abs(found[k] - roots[k]) < 2000 * std::numeric_limits<S>::epsilon());
  }
}

TEST_CASE("real_roots: degree ten with complex pairs, only those inside") {
  const std::array<double, 3> quadratic{1, 0.5, 1};  // no real root
  std::array<double, 11> c{};
  const std::array<double, 9> rest = expand(std::array<double, 8>{-3, -0.7, -0.2, 0.1, 0.4, 0.8, 2, 5}, 1.0);
  for (std::size_t i = 0; i < 9; ++i) {
    for (std::size_t j = 0; j < 3; ++j) c[i + j] += rest[i] * quadratic[j];
  }
  const auto found = real_roots<10>(c, -1.0, 1.0);
  REQUIRE(found.size() == 5);
  const std::array<double, 5> expected{-0.7, -0.2, 0.1, 0.4, 0.8};
  for (std::size_t k = 0; k < 5; ++k) CHECK(found[k] == Approx(expected[k]).margin(1e-9));
}

TEST_CASE("real_roots: none, leading zeros, NaN") {
  CHECK(real_roots<2>(std::array<double, 3>{1, 0, 1}, -10.0, 10.0).empty());
  CHECK(real_roots<4>(std::array<double, 5>{0, 0, 0, 0, 0}, -1.0, 1.0).empty());
  const auto linear = real_roots<4>(std::array<double, 5>{-1, 2, 0, 0, 0}, -1.0, 1.0);
  REQUIRE(linear.size() == 1);
  CHECK(linear[0] == Approx(0.5));
  CHECK(real_roots<3>(std::array<double, 4>{1, std::nan(""), 1, 2}, -1.0, 1.0).empty());
}
