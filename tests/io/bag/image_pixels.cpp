#include "plumbline/io/bag/image_pixels.hpp"

#include <string>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::io::bag;

namespace {

ImageMessage message(const std::string& encoding, std::uint32_t step, const std::string& pixels) {
  ImageMessage out;
  out.width = out.height = 2;
  out.step = step;
  out.encoding = encoding;
  out.data = {reinterpret_cast<const std::uint8_t*>(pixels.data()), pixels.size()};
  return out;
}
constexpr int any = cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR;

}  // namespace

TEST_CASE("gray of each encoding") {
  const std::string mono = "\x01\x02__\x03\x04";  // two bytes between the rows
  const cv::Mat gray = pixels_of(message("mono8", 4, mono), cv::IMREAD_GRAYSCALE);
  REQUIRE(gray.at<std::uint8_t>(0, 1) == 2);
  REQUIRE(gray.at<std::uint8_t>(1, 1) == 4);

  const std::string red_in_rgb("\xFF\0\0\0\xFF\0\0\0\xFF\0\0\0", 12);
  REQUIRE(pixels_of(message("rgb8", 6, red_in_rgb), cv::IMREAD_GRAYSCALE).at<std::uint8_t>(0, 0) == 76);
  REQUIRE(pixels_of(message("bgr8", 6, red_in_rgb), cv::IMREAD_GRAYSCALE).at<std::uint8_t>(0, 0) == 29);
  REQUIRE(pixels_of(message("rgb8", 6, red_in_rgb), any).at<cv::Vec3b>(0, 0) == cv::Vec3b(0, 0, 255));

  const std::string deep("\x34\x12\xFF\xFF\0\0\xFF\0", 8);
  REQUIRE(pixels_of(message("mono16", 4, deep), cv::IMREAD_GRAYSCALE).at<std::uint8_t>(0, 0) == 0x12);
  REQUIRE(pixels_of(message("mono16", 4, deep), cv::IMREAD_GRAYSCALE).at<std::uint8_t>(1, 1) == 0);
  REQUIRE(pixels_of(message("mono16", 4, deep), any).at<std::uint16_t>(0, 0) == 0x1234);
  ImageMessage big = message("16UC1", 4, deep);
  big.is_bigendian = true;
  REQUIRE(pixels_of(big, any).at<std::uint16_t>(0, 0) == 0x3412);

  const float meters[4] = {1.5F, 0, 2, 3};
  const std::string floats(reinterpret_cast<const char*>(meters), sizeof meters);
  REQUIRE(pixels_of(message("32FC1", 8, floats), any).at<float>(0, 0) == 1.5F);
}

TEST_CASE("sizes that do not fit and unknown encodings are refused") {
  const std::string pixels(12, 'x');
  const auto refusal = [&](const ImageMessage& image) { return message_of([&] { pixels_of(image, any); }); };
  REQUIRE(refusal(message("yuv422", 4, pixels)).find("is not read; read are mono8") != std::string::npos);
  REQUIRE(refusal(message("mono8", 1, pixels)).find("in rows of 1 bytes") != std::string::npos);
  REQUIRE(refusal(message("mono8", 100, pixels)).find("needs more than its 12 bytes") != std::string::npos);
  ImageMessage huge = message("mono8", 0xFFFFFFFF, pixels);
  huge.width = huge.height = 0xFFFFFFFF;
  REQUIRE(!refusal(huge).empty());
  huge.width = 0;
  REQUIRE(!refusal(huge).empty());
}

TEST_CASE("the file in a compressed message") {
  const std::string bytes = "twelve bytesPNG";
  CompressedImageMessage message;
  message.data = {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()};
  message.format = "16UC1; compressedDepth png";
  REQUIRE(file_in(message).size() == 3);
  message.format = "bgr8; jpeg compressed bgr8";
  REQUIRE(file_in(message).size() == bytes.size());
  message.format = "32FC1; compressedDepth png";
  REQUIRE(message_of([&] { file_in(message); }).find("is not read") != std::string::npos);
}
