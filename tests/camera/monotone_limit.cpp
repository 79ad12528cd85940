#include "plumbline/camera/monotone_limit.hpp"

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("monotone_limit: known roots", "", float, double) {
  using S = TestType;
  CHECK(monotone_limit<S, 3>({0, 0, 0}, 9) == S(9));
  CHECK(double(monotone_limit<S, 1>({S(-0.5)}, 9)) == Approx(2));
  CHECK(double(monotone_limit<S, 2>({S(-1.5), S(0.5)}, 9)) == Approx(1));  // (1 - q)(1 - q/2)
  CHECK(monotone_limit<S, 2>({S(-1), S(0.3)}, 9) == S(9));                 // never zero
  // (1 - q/3)(1 + q)(1 - q/5)
  CHECK(double(monotone_limit<S, 3>({S(1 - 8. / 15), S(1. / 15 - 8. / 15), S(1. / 15)}, 9)) == Approx(3));
}

TEST_CASE("monotone_limit: agrees with a dense scan") {
  Random random(2);
  for (int trial = 0; trial < 500; ++trial) {
    std::array<double, 4> c;
    for (double& value : c) value = 2 * random.uniform() - 1;
    const auto f = [&](double q) { return 1 + q * (c[0] + q * (c[1] + q * (c[2] + q * c[3]))); };
    const double limit = monotone_limit<double, 4>(c, 3.0);
    for (double q = 0; q < limit - 1e-9; q += 1e-2) REQUIRE(f(q) > -1e-12);
    if (limit < 3.0) CHECK(std::abs(f(limit)) < 1e-12);
  }
}
