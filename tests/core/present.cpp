#include "plumbline/core/present.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/core/matrix.hpp"

using namespace plumbline;

namespace {

template <bool first, bool second>
struct Holder {
  float a = 1;
  [[no_unique_address]] Present<double, first, 0> x;
  [[no_unique_address]] Present<double, second, 1> y;
};
struct Value {
  int n = 7;
};

// Nothing is kept of what is absent, and two absent members need no addresses of their own.
static_assert(sizeof(Holder<false, false>) == sizeof(float));
static_assert(sizeof(Holder<true, false>) == sizeof(Holder<false, true>));
static_assert(sizeof(Holder<true, true>) == sizeof(Holder<true, false>) + sizeof(double));
static_assert(std::is_empty_v<Present<Mat<double, 6, 6>, false>>);
static_assert(sizeof(Present<Value, true>) == sizeof(Value));
static_assert(std::is_trivially_copyable_v<Present<int, false>> && std::is_trivially_copyable_v<Present<int, true>>);

}  // namespace

TEST_CASE("present: what is there is kept") {
  Present<int, true> x(3);
  REQUIRE(x.get() == 3);
  x.set(4);
  REQUIRE(x.get() == 4);
  REQUIRE(&x.get() == &x.get());  // a reference, not a copy
}

TEST_CASE("present: what is absent swallows, and reads as nothing") {
  Present<int, false> x(3);
  REQUIRE(x.get() == 0);
  x.set(4);
  REQUIRE(x.get() == 0);
  REQUIRE(Present<Value, false>().get().n == 7);
}

TEMPLATE_TEST_CASE_SIG("present: nothing is zero of a matrix, there or absent", "", ((bool present), present), true,
                       false) {
  const Present<Vec<double, 3>, present> v;
  const Present<Mat<float, 2, 2>, present> M;
  REQUIRE(v.get() == Vec<double, 3>::Zero());
  REQUIRE(M.get().isZero(0));
  REQUIRE(Present<int, present>().get() == 0);
  REQUIRE(Present<Value, present>().get().n == 7);
}
