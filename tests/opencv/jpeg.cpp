#include "plumbline/opencv/jpeg.hpp"

#include <random>
#include <string>
#include <vector>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "catch.hpp"

using namespace plumbline::opencv;

namespace {

/// Rectangles and noise, as a camera would see a room.
cv::Mat scene(int type) {
  cv::Mat image(240, 320, type, cv::Scalar::all(90));
  cv::RNG random(3);
  for (int i = 0; i < 30; ++i) {
    const cv::Point a(random.uniform(0, 320), random.uniform(0, 240)),
        b(random.uniform(0, 320), random.uniform(0, 240));
    cv::rectangle(image, a, b, cv::Scalar(random.uniform(0, 255), random.uniform(0, 255), random.uniform(0, 255)),
                  cv::FILLED);
  }
  cv::Mat noise(image.size(), type);
  random.fill(noise, cv::RNG::UNIFORM, 0, 20);
  return image + noise;
}

std::string encoded(const cv::Mat& image, std::vector<int> parameters = {}) {
  std::vector<unsigned char> bytes;
  REQUIRE(cv::imencode(".jpg", image, bytes, parameters));
  return {bytes.begin(), bytes.end()};
}

cv::Mat decoded_by_opencv(const std::string& bytes) {
  return cv::imdecode(std::vector<unsigned char>(bytes.begin(), bytes.end()), cv::IMREAD_GRAYSCALE);
}

}  // namespace

TEST_CASE("jpeg: the pixels are those of OpenCV") {
  for (const std::string& bytes :
       {encoded(scene(CV_8U)), encoded(scene(CV_8UC3)), encoded(scene(CV_8UC3), {cv::IMWRITE_JPEG_PROGRESSIVE, 1}),
        encoded(scene(CV_8U), {cv::IMWRITE_JPEG_RST_INTERVAL, 4})}) {
    cv::Mat gray;
    REQUIRE(decode_jpeg(bytes, gray));
    const cv::Mat expected = decoded_by_opencv(bytes);
    REQUIRE((gray.size() == expected.size() && gray.type() == CV_8U));
    REQUIRE(cv::norm(gray, expected, cv::NORM_INF) == 0);
  }
}

TEST_CASE("jpeg: what is none") {
  cv::Mat gray;
  for (const char* bytes : {"", "\xFF\xD8", "\xFF\xD8\xFF\xD9", "no image"}) REQUIRE(!decode_jpeg(bytes, gray));
  REQUIRE(!decode_jpeg(encoded(scene(CV_8U)).substr(0, 300), gray));
}

TEST_CASE("jpeg: bytes overwritten in the middle are noticed") {
  const std::string whole = encoded(scene(CV_8U));
  std::mt19937 random(5);
  cv::Mat gray;
  int noticed = 0;
  constexpr int trials = 400;
  for (int trial = 0; trial < trials; ++trial) {
    std::string bytes = whole;
    const std::size_t begin = 700 + random() % (bytes.size() - 1000);
    for (std::size_t i = begin; i < begin + 64; ++i) bytes[i] = static_cast<char>(random());
    noticed += !decode_jpeg(bytes, gray);
  }
  CAPTURE(noticed);
  REQUIRE(noticed > 0.97 * trials);
}

TEST_CASE("jpeg: a gap in the data is noticed") {
  const std::string whole = encoded(scene(CV_8U));
  cv::Mat gray;
  int missed = 0, trials = 0;
  for (std::size_t begin = 1000; begin + 3000 < whole.size(); begin += 100, trials += 2) {
    missed += decode_jpeg(std::string(whole).erase(begin, 512), gray);
    missed += decode_jpeg(std::string(whole).replace(begin, 512, 512, '\0'), gray);
  }
  CAPTURE(missed, trials);
  REQUIRE(missed < 0.03 * trials);
}

TEST_CASE("jpeg: a few bytes of padding before the end are accepted") {
  std::string bytes = encoded(scene(CV_8U));
  bytes.insert(bytes.size() - 2, "\0\0", 2);
  cv::Mat gray;
  REQUIRE(decode_jpeg(bytes, gray));
}
