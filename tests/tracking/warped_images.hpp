#pragma once
// Image pairs with a known motion: a textured synthetic image, and recorded images warped by OpenCV with gain, bias and
// noise on top. Recordings lie beside the project; without them only the synthetic image is used.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"

namespace plumbline::testing {

using Vec2f = Vec<float, 2>;

/// uv_current = A uv_reference + t [px].
struct AffineMotion {
  Mat<float, 2, 2> A = Mat<float, 2, 2>::Identity();
  Vec2f t = Vec2f::Zero();
  Vec2f operator()(const Vec2f& uv) const { return A * uv + t; }
};

/// Rotation and scale about the image center, then a shift.
inline AffineMotion about_center(const cv::Mat& image, float degrees, float scale, const Vec2f& shift) {
  const float angle = degrees * 3.14159265f / 180.0f;
  AffineMotion motion;
  motion.A << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  motion.A *= scale;
  const Vec2f center(0.5f * static_cast<float>(image.cols - 1), 0.5f * static_cast<float>(image.rows - 1));
  motion.t = center - motion.A * center + shift;
  return motion;
}

/// Smoothed random blocks of several sizes: texture on all levels of a pyramid.
inline cv::Mat textured_image(int width = 640, int height = 480, std::uint64_t seed = 1) {
  Random random(seed);
  cv::Mat sum = cv::Mat::zeros(height, width, CV_32F);
  for (const int block : {8, 20, 50}) {
    cv::Mat coarse(height / block + 1, width / block + 1, CV_32F);
    coarse.forEach<float>([](float& value, const int*) { value = 0; });
    for (int y = 0; y < coarse.rows; ++y) {
      for (int x = 0; x < coarse.cols; ++x) coarse.at<float>(y, x) = static_cast<float>(random.uniform() * 85.0);
    }
    cv::Mat blocks;
    cv::resize(coarse, blocks, {coarse.cols * block, coarse.rows * block}, 0, 0, cv::INTER_NEAREST);
    sum += blocks(cv::Rect(0, 0, width, height));
  }
  cv::GaussianBlur(sum, sum, {5, 5}, 1.0);
  cv::Mat image;
  sum.convertTo(image, CV_8U);
  return image;
}

inline cv::Mat with_noise(const cv::Mat& image, double sigma, std::uint64_t seed) {
  cv::Mat noise(image.size(), CV_32F), sum;
  cv::RNG(seed).fill(noise, cv::RNG::NORMAL, 0.0, sigma);
  image.convertTo(sum, CV_32F);
  sum += noise;
  cv::Mat out;
  sum.convertTo(out, CV_8U);
  return out;
}

/// The image after the motion, its intensities times `gain` plus `bias`.
inline cv::Mat warped(const cv::Mat& image, const AffineMotion& motion, double gain = 1.0, double bias = 0.0) {
  const cv::Mat M = (cv::Mat_<double>(2, 3) << motion.A(0, 0), motion.A(0, 1), motion.t.x(), motion.A(1, 0),
                     motion.A(1, 1), motion.t.y());
  cv::Mat out, scaled;
  cv::warpAffine(image, out, M, image.size(), cv::INTER_CUBIC, cv::BORDER_REFLECT);
  out.convertTo(scaled, CV_8U, gain, bias);
  return scaled;
}

inline const std::string recordings = PLUMBLINE_TEST_DATA;

/// A few images of every recording that is there.
inline std::vector<cv::Mat> recorded_images() {
  std::vector<cv::Mat> images;
  for (const char* folder : {"euroc_mh01_flight/mav0/cam0/data", "tum_fr1_rpy_first12s/rgb", "kitti00_first20s/image_0",
                             "rendered_office_mono/mav0/cam0/data", "icl_office_kt0_3s/rgb"}) {
    const std::filesystem::path path = std::filesystem::path(recordings) / folder;
    if (!std::filesystem::is_directory(path)) continue;
    std::vector<std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(path)) files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    for (const std::size_t part : {1u, 3u}) {
      if (!files.empty()) images.push_back(cv::imread(files[part * files.size() / 4], cv::IMREAD_GRAYSCALE));
    }
  }
  return images;
}

inline double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
}

}  // namespace plumbline::testing
