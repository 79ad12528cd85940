#include "plumbline/image/patch_sums.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;

namespace {

template <int N>
void compare() {
  CAPTURE(N);
  Vec<float, N> a, b;
  for (int k = 0; k < N; ++k) {
    a[k] = 100 * std::sin(float(1 + 3 * k));
    b[k] = 50 * std::cos(float(2 + 5 * k));
  }
  const float mean = a.mean();
  CHECK(mean_of(a) == mean);
  CHECK(sum_of_products(a, b) == a.dot(b));
  CHECK(sum_of_squares(a) == a.squaredNorm());
  CHECK(squared_norm_about(a, mean) == (a.array() - mean).matrix().squaredNorm());
}

}  // namespace

#ifndef __FMA__
TEST_CASE("patch sums: those of Eigen to the last bit") {
  compare<9>();
  compare<25>();
  compare<64>();
  compare<100>();
  compare<144>();
  compare<196>();
}
#endif
