#include "plumbline/opencv/image_file.hpp"

#include <sys/stat.h>

#include <fstream>
#include <limits>
#include <string>
#include <vector>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::opencv;

namespace {

template <class Pixel>
cv::Mat ramp(int type) {
  cv::Mat image(48, 64, type);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) image.at<Pixel>(y, x) = Pixel(x * 3 + y);
  return image;
}

std::string encoded(const cv::Mat& image, const char* extension) {
  std::vector<unsigned char> bytes;
  REQUIRE(cv::imencode(extension, image, bytes));
  return {bytes.begin(), bytes.end()};
}

}  // namespace

TEST_CASE("image_file: whole images") {
  const TemporaryDirectory directory;
  const cv::Mat gray = ramp<std::uint8_t>(CV_8U), depth = ramp<std::uint16_t>(CV_16U);
  const cv::Mat read = read_gray(directory.write("a.png", encoded(gray, ".png")));
  REQUIRE((read.type() == CV_8U && cv::norm(read, gray, cv::NORM_INF) == 0));
  REQUIRE(cv::norm(read_gray(directory.write("a.jpg", encoded(gray, ".jpg"))), gray, cv::NORM_INF) < 12);
  REQUIRE(cv::norm(read_depth(directory.write("d.png", encoded(depth, ".png"))), depth, cv::NORM_INF) == 0);
  const cv::Mat color(48, 64, CV_8UC3, cv::Scalar(50, 50, 50));
  REQUIRE(read_gray(directory.write("c.png", encoded(color, ".png"))).at<std::uint8_t>(7, 7) == 50);
  const std::string padded = encoded(gray, ".jpg") + std::string(16, '\0');
  REQUIRE(read_gray(directory.write("p.jpg", padded)).cols == 64);
}

TEST_CASE("image_file: cut anywhere, an image is refused") {
  const TemporaryDirectory directory;
  for (const char* extension : {".png", ".jpg"}) {
    const std::string bytes = encoded(ramp<std::uint8_t>(CV_8U), extension);
    for (const std::size_t length : {bytes.size() - 1, bytes.size() - 10, bytes.size() / 2, std::size_t{9}}) {
      const auto file = directory.write(std::string("cut") + extension, bytes.substr(0, length));
      CAPTURE(extension, length);
      REQUIRE(reports(message_of([&] { read_gray(file); }), file, 0, "the image is cut off"));
    }
  }
}

TEST_CASE("image_file: corrupt and empty files, no files") {
  const TemporaryDirectory directory;
  std::string bytes = encoded(ramp<std::uint8_t>(CV_8U), ".png");
  for (std::size_t i = 45; i < 60; ++i) bytes[i] = static_cast<char>(~bytes[i]);
  const auto corrupt = directory.write("corrupt.png", bytes), empty = directory.write("empty.png", "");
  const auto text = directory.write("text.png", "no image");
  REQUIRE(reports(message_of([&] { read_gray(corrupt); }), corrupt, 0, "not an image that can be decoded"));
  REQUIRE(reports(message_of([&] { read_gray(empty); }), empty, 0, "the file is empty"));
  REQUIRE(reports(message_of([&] { read_gray(text); }), text, 0, "not an image that can be decoded"));
  REQUIRE(reports(message_of([&] { read_gray(directory.path()); }), directory.path(), 0, "not a regular file"));
  REQUIRE(reports(message_of([] { read_gray("/nowhere.png"); }), "/nowhere.png", 0, "cannot be opened"));
}

TEST_CASE("image_file: a pipe is no image, and is not waited for") {
  const TemporaryDirectory directory;
  const auto pipe = directory.path() / "pipe.png";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  REQUIRE(reports(message_of([&] { read_gray(pipe); }), pipe, 0, "not a regular file"));
}

TEST_CASE("image_file: a JPEG damaged in the middle is refused") {
  const TemporaryDirectory directory;
  std::string bytes = encoded(ramp<std::uint8_t>(CV_8U), ".jpg");
  bytes.erase(bytes.size() / 2 + bytes.size() / 4, 100);
  const auto file = directory.write("a.jpg", bytes);
  REQUIRE(reports(message_of([&] { read_gray(file); }), file, 0, "the image is damaged"));
}

TEST_CASE("image_file: depth must be 16-bit, images of the calibrated size") {
  const TemporaryDirectory directory;
  const auto file = directory.write("a.png", encoded(ramp<std::uint8_t>(CV_8U), ".png"));
  REQUIRE(reports(message_of([&] { read_depth(file); }), file, 0,
                  "an 8-bit image: a picture of depth, not its values; 16 bits, or 32-bit float in meters, are read"));
  REQUIRE(reports(message_of([&] { require_resolution(read_gray(file), 640, 480, file); }), file, 0,
                  "the image is 64 x 48, the calibration has 640 x 480"));
  REQUIRE(message_of([&] { require_resolution(read_gray(file), 64, 48, file); }).empty());
}

TEST_CASE("image_file: 10 and 12 bits in 16") {
  const TemporaryDirectory directory;
  cv::Mat gray(48, 64, CV_8U);
  cv::randu(gray, 0, 256);
  for (const int bits : {8, 10, 12, 16}) {
    CAPTURE(bits);
    cv::Mat wide;
    gray.convertTo(wide, CV_16U, 1 << (bits - 8));
    wide.at<std::uint16_t>(0, 0) = static_cast<std::uint16_t>((1 << bits) - 1);
    const auto file = directory.write("w.png", encoded(wide, ".png"));
    REQUIRE(used_gray_bits({file}) == bits);
    cv::Mat read = read_gray(file, bits);
    read.at<std::uint8_t>(0, 0) = gray.at<std::uint8_t>(0, 0);
    REQUIRE(cv::norm(read, gray, cv::NORM_INF) <= 1);
  }
  REQUIRE(used_gray_bits({directory.write("g.png", encoded(gray, ".png"))}) == 16);
  REQUIRE(used_gray_bits({directory.path() / "none.png"}) == 16);
}

TEST_CASE("image_file: depth in meters") {
  const TemporaryDirectory directory;
  cv::Mat meters(2, 2, CV_32F, cv::Scalar(1.5));
  meters.at<float>(0, 1) = std::numeric_limits<float>::quiet_NaN();
  meters.at<float>(1, 0) = std::numeric_limits<float>::infinity();
  const auto file = directory.write("d.tiff", encoded(meters, ".tiff"));
  const cv::Mat depth = read_depth(file, 1000);
  REQUIRE((depth.type() == CV_16U && depth.at<std::uint16_t>(0, 0) == 1500 && depth.at<std::uint16_t>(1, 1) == 1500));
  REQUIRE((depth.at<std::uint16_t>(0, 1) == 0 && depth.at<std::uint16_t>(1, 0) == 0));
  REQUIRE(reports(message_of([&] { read_depth(file); }), file, 0, "not a 16-bit image with one channel"));
}
