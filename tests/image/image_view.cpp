#include "plumbline/image/image_view.hpp"

#include <array>
#include <cmath>
#include <cstdint>
#include <type_traits>

#include "catch.hpp"

using namespace plumbline;

namespace {
std::array<std::uint8_t, 20> pixels{0, 1, 2, 3, 90, 10, 11, 12, 13, 91, 20, 21, 22, 23, 92, 30, 31, 32, 33, 93};
const ImageView<std::uint8_t> view{pixels.data(), 4, 4, 5};  // the left part of rows of five
}  // namespace

TEST_CASE("image_view: pixels by column and row, rows a stride apart") {
  REQUIRE(view(0, 0) == 0);
  REQUIRE(view(3, 2) == 23);
  REQUIRE(view.row(3)[1] == 31);
  const ImageView<const std::uint8_t> read_only = view;
  REQUIRE(&read_only(2, 1) == &view(2, 1));
  static_assert(!std::is_convertible_v<ImageView<const std::uint8_t>, ImageView<std::uint8_t>>);
}

TEST_CASE("image_view: empty without pixels or without size") {
  REQUIRE_FALSE(view.empty());
  REQUIRE(ImageView<std::uint8_t>{}.empty());
  REQUIRE(ImageView<std::uint8_t>{pixels.data(), 0, 4, 5}.empty());
  REQUIRE(ImageView<std::uint8_t>{pixels.data(), 4, -1, 5}.empty());
}

TEMPLATE_TEST_CASE("image_view: contains keeps the border, and no NaN is inside", "", float, double) {
  using S = TestType;
  REQUIRE(view.contains(S(0), S(0), S(0)));
  REQUIRE(view.contains(S(3), S(3), S(0)));
  REQUIRE_FALSE(view.contains(S(-0.01), S(1), S(0)));
  REQUIRE_FALSE(view.contains(S(3.01), S(1), S(0)));
  REQUIRE_FALSE(view.contains(S(1), S(3.01), S(0)));
  REQUIRE(view.contains(S(1), S(2), S(1)));
  REQUIRE_FALSE(view.contains(S(0.9), S(2), S(1)));
  REQUIRE_FALSE(view.contains(S(NAN), S(1), S(0)));
  REQUIRE_FALSE(view.contains(S(1), S(NAN), S(0)));
  REQUIRE_FALSE(ImageView<std::uint8_t>{}.contains(S(0), S(0), S(0)));
}

TEMPLATE_TEST_CASE("image_view: interpolation is exact on planes and at pixels", "", float, double) {
  using S = TestType;
  REQUIRE(interpolate(view, S(2), S(1)) == S(12));
  for (const S x : {S(0), S(0.25), S(1.5), S(2.9)}) {
    for (const S y : {S(0), S(0.75), S(2.5)}) REQUIRE(interpolate(view, x, y) == Approx(x + 10 * y).margin(1e-5));
  }
}
