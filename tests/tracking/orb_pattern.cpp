#include "plumbline/tracking/orb_pattern.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("orb pattern: all points are in the disc, and the two of a pair are apart") {
  for (std::size_t i = 0; i < OrbPattern::pairs; ++i) {
    const float px = orb_pattern.px[i], py = orb_pattern.py[i], qx = orb_pattern.qx[i], qy = orb_pattern.qy[i];
    REQUIRE(std::hypot(px, py) <= OrbPattern::radius);
    REQUIRE(std::hypot(qx, qy) <= OrbPattern::radius);
    REQUIRE(std::hypot(px - qx, py - qy) >= 2);
  }
}

TEST_CASE("orb pattern: centered, as wide as the rule says, no pair twice") {
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < OrbPattern::pairs; ++i) {
    for (const float x : {orb_pattern.px[i], orb_pattern.py[i], orb_pattern.qx[i], orb_pattern.qy[i]}) {
      sum += x;
      squares += double(x) * x;
    }
    for (std::size_t k = 0; k < i; ++k) {
      REQUIRE(!(orb_pattern.px[i] == orb_pattern.px[k] && orb_pattern.py[i] == orb_pattern.py[k] &&
                orb_pattern.qx[i] == orb_pattern.qx[k] && orb_pattern.qy[i] == orb_pattern.qy[k]));
    }
  }
  const double n = 4.0 * OrbPattern::pairs;
  REQUIRE(std::abs(sum / n) < 0.6);                                  // three sigma of the mean
  REQUIRE(std::sqrt(squares / n) == Approx(31.0 / 5).epsilon(0.1));  // the disc cuts the tails
}

TEST_CASE("orb pattern: another seed is another pattern, and the compiler computes it") {
  static_assert(detail::make_orb_pattern(1).px == orb_pattern.px);
  const OrbPattern other = detail::make_orb_pattern(2);
  REQUIRE(other.px != orb_pattern.px);
}
