#include "plumbline/tracking/fast_contrast.hpp"

#include <algorithm>

#include "catch.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "tracking/corner_definitions.hpp"
#include "tracking/warped_images.hpp"

using namespace plumbline;

TEST_CASE("fast contrast: the least threshold that a pixel does not pass") {
  constexpr int size = 32;
  for (const double noise : {2.0, 20.0, 100.0}) {
    const cv::Mat image = testing::with_noise(testing::textured_image(size + 6, 60), noise, 3);
    const testing::GrayView view = opencv::view<std::uint8_t>(image);
    const FastContrast fast(view.stride);
    int corners = 0;
    for (int y = 3; y < view.height - 3; ++y) {
      const auto contrasts = fast.of_row<size>(view.row(y) + 3);
      for (int x = 0; x < size; ++x) {
        const int contrast = contrasts[std::size_t(x)];
        REQUIRE_FALSE(testing::is_fast_corner(view, x + 3, y, contrast));
        if (contrast > 0) REQUIRE(testing::is_fast_corner(view, x + 3, y, contrast - 1));
        corners += contrast > 7;
      }
      REQUIRE(fast.bound_of_row<size>(view.row(y) + 3) >= *std::max_element(contrasts.begin(), contrasts.end()));
    }
    REQUIRE(corners > 10);
  }
}

TEST_CASE("fast contrast: black beside white does not overflow, and a bound holds no pixel that is flat") {
  cv::Mat image(7, 38, CV_8U, cv::Scalar(0));
  image.at<std::uint8_t>(3, 10) = 255;
  const FastContrast fast(opencv::view<std::uint8_t>(image).stride);
  const auto contrasts = fast.of_row<32>(image.ptr(3) + 3);
  for (std::size_t x = 0; x < 32; ++x) REQUIRE(contrasts[x] == (x == 7 ? 255 : 0));
  REQUIRE(fast.bound_of_row<32>(image.ptr(3) + 3) == 255);
  image.setTo(90);
  REQUIRE(fast.bound_of_row<32>(image.ptr(3) + 3) == 0);
}
