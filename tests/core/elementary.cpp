#include "plumbline/core/elementary.hpp"

#include <array>
#include <cmath>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/core/fixed_elementary.hpp"

using namespace plumbline;

namespace {

#ifdef PLUMBLINE_REPRODUCIBLE
namespace chosen = fixed_elementary;
#else
namespace chosen = std;
#endif

template <class S>
std::array<S, 11> all_of(S x) {
  return {elementary::acos(x), elementary::atan2(x, S(2)), elementary::cbrt(x),     elementary::cos(x),
          elementary::exp(x),  elementary::hypot(x, S(2)), elementary::log(x),      elementary::log1p(x),
          elementary::sin(x),  elementary::tan(x),         S(elementary::pow(x, 3))};
}

}  // namespace

TEMPLATE_TEST_CASE("elementary: each function is the one that the build has chosen, bit for bit", "", float, double) {
  using S = TestType;
  for (const S x : {S(1e-3), S(0.3), S(0.7), S(0.99)}) {
    CHECK(all_of(x) == std::array<S, 11>{chosen::acos(x), chosen::atan2(x, S(2)), chosen::cbrt(x), chosen::cos(x),
                                         chosen::exp(x), chosen::hypot(x, S(2)), chosen::log(x), chosen::log1p(x),
                                         chosen::sin(x), chosen::tan(x), S(chosen::pow(x, 3))});
  }
  STATIC_REQUIRE(std::is_same_v<decltype(elementary::sin(S(0))), S>);
  STATIC_REQUIRE(std::is_same_v<decltype(elementary::hypot(S(0), S(0))), S>);
}
