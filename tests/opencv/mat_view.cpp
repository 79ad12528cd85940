#include "plumbline/opencv/mat_view.hpp"

#include <cstdint>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("mat_view: a part of an image, there and back, are the same pixels") {
  cv::Mat whole(20, 30, CV_16U, cv::Scalar(7));
  const cv::Mat part = whole(cv::Rect(4, 3, 11, 9));
  const ImageView<const std::uint16_t> view = opencv::view<std::uint16_t>(part);
  REQUIRE((view.width == 11 && view.height == 9 && view.stride == 30));
  whole.at<std::uint16_t>(3 + 5, 4 + 2) = 99;
  REQUIRE(view(2, 5) == 99);
  const cv::Mat back = opencv::mat(view);
  REQUIRE((back.size() == part.size() && back.type() == CV_16U && back.data == part.data && back.step == part.step));
}

TEST_CASE("mat_view: another type of pixel and no image give nothing") {
  REQUIRE(opencv::view<std::uint8_t>(cv::Mat(4, 4, CV_16U)).empty());
  REQUIRE(opencv::view<std::uint8_t>(cv::Mat()).empty());
  REQUIRE(opencv::mat(ImageView<const std::uint8_t>()).empty());
}
