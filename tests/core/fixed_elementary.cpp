#include "plumbline/core/fixed_elementary.hpp"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "catch.hpp"

using namespace plumbline;
namespace fixed = plumbline::fixed_elementary;

namespace {

/// Largest distance from the function of the C library, in units in the last place of the result.
template <class S>
double error_ulp(auto&& f, auto&& reference, double begin, double end, bool logarithmic = false) {
  double worst = 0;
  for (int i = 0; i <= 20000; ++i) {
    const double u = i / 20000.0;
    const S x = S(logarithmic ? begin * std::pow(end / begin, u) : begin + (end - begin) * u);
    const S expected = S(reference(x)), actual = f(x);
    const S size = std::max(std::abs(expected), std::numeric_limits<S>::min());
    const S ulp = std::nextafter(size, std::numeric_limits<S>::infinity()) - size;
    worst = std::max(worst, std::abs(double(actual) - double(expected)) / double(ulp));
  }
  return worst;
}

}  // namespace

TEMPLATE_TEST_CASE("fixed_elementary: agrees with the C library to four units in the last place", "", float, double) {
  using S = TestType;
  const double limit = std::is_same_v<S, float> ? 1 : 4;
  const auto check = [&](const char* name, auto&& f, auto&& reference, double begin, double end, bool logarithmic) {
    INFO(name << " from " << begin << " to " << end);
    CHECK(error_ulp<S>(f, reference, begin, end, logarithmic) <= limit);
  };
#define CHECK_FUNCTION(name, begin, end, logarithmic) \
  check(                                              \
      #name, [](S x) { return fixed::name(x); }, [](S x) { return std::name(x); }, begin, end, logarithmic)
  CHECK_FUNCTION(sin, -3.1, 3.1, false);
  CHECK_FUNCTION(sin, 1e-6, 1.5, true);
  CHECK_FUNCTION(cos, -1.5, 1.5, false);
  CHECK_FUNCTION(cos, 2, 4, false);
  CHECK_FUNCTION(exp, -80, 80, false);
  CHECK_FUNCTION(log, 1e-30, 1e30, true);
  CHECK_FUNCTION(log, 0.5, 2, false);
  CHECK_FUNCTION(log1p, -0.99, 3, false);
  CHECK_FUNCTION(log1p, 1e-20, 1e-3, true);
  CHECK_FUNCTION(tan, -1.5, 1.5, false);
  CHECK_FUNCTION(acos, -0.9, 0.9, false);
  CHECK_FUNCTION(cbrt, 1e-30, 1e30, true);
  CHECK_FUNCTION(cbrt, -2, -0.1, false);
#undef CHECK_FUNCTION
  for (const S y : {S(-2), S(-0.3), S(0.3), S(2)}) {
    CHECK(error_ulp<S>([&](S x) { return fixed::atan2(y, x); }, [&](S x) { return std::atan2(y, x); }, -3, 3) <= limit);
    CHECK(error_ulp<S>([&](S x) { return fixed::hypot(y, x); }, [&](S x) { return std::hypot(y, x); }, -3, 3) <= limit);
  }
  CHECK(fixed::pow(S(3), 3) == S(27));
  CHECK(fixed::pow(S(-0.5), 3) == S(-0.125));
  CHECK(fixed::pow(S(7), 0) == S(1));
}

TEST_CASE("fixed_elementary: large angles") {
  CHECK(fixed::sin(1e4) == Approx(std::sin(1e4)).epsilon(1e-12));
  CHECK(fixed::cos(-9e4) == Approx(std::cos(-9e4)).epsilon(1e-11));
  CHECK(std::abs(fixed::sin(1e8)) <= 1);
}

TEST_CASE("fixed_elementary: limits, zeros and NaN") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
  CHECK(std::isnan(fixed::sin(nan)));
  CHECK(std::isnan(fixed::cos(infinity)));
  CHECK(std::isnan(fixed::exp(nan)));
  CHECK(std::isnan(fixed::log(nan)));
  CHECK(std::isnan(fixed::log(-1.0)));
  CHECK(std::isnan(fixed::log1p(nan)));
  CHECK(std::isnan(fixed::acos(1.1)));
  CHECK(std::isnan(fixed::cbrt(nan)));
  CHECK(std::isnan(fixed::atan2(nan, 1.0)));
  CHECK(std::isnan(fixed::atan2(1.0, nan)));
  CHECK(std::isnan(fixed::atan2(nan, 0.0)));
  CHECK(std::isnan(fixed::hypot(nan, 0.0)));
  CHECK(std::isnan(fixed::hypot(0.0, nan)));
  CHECK(fixed::exp(-infinity) == 0);
  CHECK(fixed::exp(infinity) == infinity);
  CHECK(fixed::exp(0.0) == 1);
  CHECK(fixed::log(0.0) == -infinity);
  CHECK(fixed::log(infinity) == infinity);
  CHECK(fixed::log(1.0) == 0);
  CHECK(fixed::log(5e-324) == Approx(std::log(5e-324)));
  CHECK(fixed::log1p(-1.0) == -infinity);
  CHECK(fixed::cbrt(-27.0) == -3);
  CHECK(fixed::cbrt(0.0) == 0);
  CHECK(fixed::hypot(0.0, 0.0) == 0);
  CHECK(fixed::hypot(-3.0, 4.0) == 5);
  CHECK(fixed::hypot(1e300, 1e300) == Approx(std::sqrt(2.0) * 1e300));
  CHECK(fixed::hypot(infinity, 1.0) == infinity);
  for (const double y : {0.0, -0.0, 1.0, -1.0, infinity, -infinity}) {
    for (const double x : {0.0, -0.0, 1.0, -1.0, infinity, -infinity}) {
      INFO(y << ", " << x);
      CHECK(fixed::atan2(y, x) == std::atan2(y, x));
      CHECK(std::signbit(fixed::atan2(y, x)) == std::signbit(std::atan2(y, x)));
    }
  }
  static_assert(std::is_same_v<decltype(fixed::hypot(1.0f, 1.0)), double>);
  static_assert(std::is_same_v<decltype(fixed::atan2(1.0f, 1.0f)), float>);
}

// All bits of many results: the same number with every compiler, processor and C library. A processor with FMA needs
// -ffp-contract=off, which a reproducible build has.
#if defined(PLUMBLINE_REPRODUCIBLE) || !defined(__FP_FAST_FMA)
TEST_CASE("fixed_elementary: the same bits everywhere") {
  std::uint64_t hash = 0;
  const auto add = [&](double y) { hash = std::rotl(hash, 5) * 0x9e3779b97f4a7c15u + std::bit_cast<std::uint64_t>(y); };
  for (int i = 1; i <= 1000; ++i) {
    const double x = i * 0x1p-8;
    for (const double y : {fixed::sin(x), fixed::cos(x), fixed::tan(x), fixed::exp(x), fixed::log(x), fixed::log1p(x),
                           fixed::cbrt(x), fixed::acos(x / 4), fixed::atan2(x, 1.5), fixed::hypot(x, 1.5)}) {
      add(y);
    }
  }
  CHECK(hash == 0x60f86076a11ab26d);
}
#endif
