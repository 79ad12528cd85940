#pragma once
/// Images from files, whole or not at all: a decoder fills what a cut file lacks with gray without an error, and an
/// estimator would take that for a scene. Each function throws std::runtime_error "file: what is wrong".

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <string_view>

#include <opencv2/imgcodecs.hpp>

#include "plumbline/opencv/jpeg.hpp"

namespace plumbline::opencv {

namespace detail {

/// A JPEG ends with the marker FF D9; some cameras pad their files with zeros.
inline bool is_complete_jpeg(std::string_view bytes) {
  return bytes.substr(0, bytes.find_last_not_of('\0') + 1).ends_with("\xFF\xD9");
}

/// A PNG is a signature of 8 bytes and chunks (length, type, data, check sum), the last of them IEND.
inline bool is_complete_png(std::string_view bytes) {
  for (std::size_t at = 8; at + 12 <= bytes.size();) {
    std::size_t length = 0;
    for (std::size_t i = 0; i < 4; ++i) length = length << 8 | static_cast<std::uint8_t>(bytes[at + i]);
    if (bytes.size() - at - 12 < length) return false;
    if (bytes.substr(at + 4, 4) == "IEND") return true;
    at += length + 12;
  }
  return false;
}

inline bool is_complete(std::string_view bytes) {
  if (bytes.starts_with("\xFF\xD8")) return is_complete_jpeg(bytes);
  if (bytes.starts_with("\x89PNG")) return is_complete_png(bytes);
  return true;
}

/// `flags` are those of cv::imread; pixels stay where the sensor had them, whatever orientation the file states.
inline cv::Mat read_image(const std::filesystem::path& file, int flags) {
  const std::filesystem::file_status status = std::filesystem::status(file);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))  // a pipe would not answer
    throw std::runtime_error(file.string() + ": not a regular file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be opened");
  std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  if (bytes.empty()) throw std::runtime_error(file.string() + ": the file is empty");
  if (!is_complete(bytes)) throw std::runtime_error(file.string() + ": the image is cut off");
  cv::Mat image;
  if (flags == cv::IMREAD_GRAYSCALE && bytes.starts_with("\xFF\xD8")) {
    if (decode_jpeg(bytes, image)) return image;
    throw std::runtime_error(file.string() + ": the image is damaged");
  }
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, bytes.data());
    image = cv::imdecode(buffer, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) throw std::runtime_error(file.string() + ": not an image that can be decoded");
  return image;
}

}  // namespace detail

/// 8-bit gray, CV_8U; color is converted.
inline cv::Mat read_gray(const std::filesystem::path& file) { return detail::read_image(file, cv::IMREAD_GRAYSCALE); }

/// Depth as recorded, CV_16U.
inline cv::Mat read_depth(const std::filesystem::path& file) {
  cv::Mat depth = detail::read_image(file, cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
  if (depth.type() != CV_16U) throw std::runtime_error(file.string() + ": not a 16-bit image with one channel");
  return depth;
}

/// Throws unless the image has the calibrated size.
inline void require_resolution(const cv::Mat& image, int width, int height, const std::filesystem::path& file) {
  const auto text = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  if (image.cols != width || image.rows != height)
    throw std::runtime_error(file.string() + ": the image is " + text(image.cols, image.rows) +
                             ", the calibration has " + text(width, height));
}

}  // namespace plumbline::opencv
