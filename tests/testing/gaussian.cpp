#include "plumbline/testing/gaussian.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;
using namespace plumbline::testing;

TEST_CASE("gaussian: the moments of the normal distribution") {
  Gaussian normal(3);
  constexpr int count = 200000;
  double sum = 0, sum2 = 0, sum4 = 0, previous = 0, lag = 0;
  int beyond_2 = 0;
  for (int i = 0; i < count; ++i) {
    const double x = normal();
    sum += x, sum2 += x * x, sum4 += x * x * x * x, lag += x * previous;
    beyond_2 += std::abs(x) > 2;
    previous = x;
  }
  REQUIRE(std::abs(sum / count) < 0.01);
  REQUIRE(sum2 / count == Approx(1).margin(0.015));
  REQUIRE(sum4 / count == Approx(3).margin(0.12));
  REQUIRE(std::abs(lag / count) < 0.01);
  REQUIRE(beyond_2 / double(count) == Approx(0.0455).margin(0.002));
}

TEST_CASE("gaussian: same seed, same numbers; other streams are others") {
  Gaussian a(stream_seed(1, 2, 3)), b(stream_seed(1, 2, 3)), c(stream_seed(1, 3, 2));
  const double first = a();
  REQUIRE(first == b());
  REQUIRE(first != c());
}
