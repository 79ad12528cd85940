#pragma once
/// Images from files, whole or not at all: a decoder fills what a cut file lacks with gray without an error, and an
/// estimator would take that for a scene. Each function throws std::runtime_error "file: what is wrong".

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <opencv2/core.hpp>
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

}  // namespace detail

/// Decodes a whole JPEG or PNG, which errors call `name`. `flags` are those of cv::imread; pixels stay where the sensor
/// had them, whatever orientation the file states.
inline cv::Mat decode_image(std::span<const std::uint8_t> bytes, int flags, const std::filesystem::path& name) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.empty()) throw std::runtime_error(name.string() + ": the file is empty");
  if (!detail::is_complete(text)) throw std::runtime_error(name.string() + ": the image is cut off");
  cv::Mat image;
  if (flags == cv::IMREAD_GRAYSCALE && text.starts_with("\xFF\xD8")) {
    if (decode_jpeg(text, image)) return image;
    throw std::runtime_error(name.string() + ": the image is damaged");
  }
  try {
    const cv::Mat buffer(1, static_cast<int>(bytes.size()), CV_8U, const_cast<std::uint8_t*>(bytes.data()));
    image = cv::imdecode(buffer, flags | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    image.release();
  }
  if (image.empty()) throw std::runtime_error(name.string() + ": not an image that can be decoded");
  return image;
}

namespace detail {

inline cv::Mat read_image(const std::filesystem::path& file, int flags) {
  const std::filesystem::file_status status = std::filesystem::status(file);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))  // a pipe would not answer
    throw std::runtime_error(file.string() + ": not a regular file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file.string() + ": cannot be opened");
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(file, error);  // one character after the other is slow
  std::string bytes(error ? 0 : static_cast<std::size_t>(size), '\0');
  stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  bytes.resize(static_cast<std::size_t>(stream.gcount()));
  return decode_image({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, flags, file);
}

}  // namespace detail

/// 8-bit gray, CV_8U, of what `read` gives for flags of cv::imread; color is converted. Of an image of 16 bits the
/// upper 8 of those that are used: `used_bits` is 10 or 12 for cameras that leave the upper ones zero.
template <class Read>
cv::Mat gray_of(Read&& read, int used_bits) {
  if (used_bits == 16) return read(cv::IMREAD_GRAYSCALE);
  cv::Mat gray = read(cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
  if (gray.depth() == CV_16U) gray.convertTo(gray, CV_8U, std::ldexp(1.0, 8 - used_bits));
  return gray;
}

inline cv::Mat read_gray(const std::filesystem::path& file, int used_bits = 16) {
  return gray_of([&](int flags) { return detail::read_image(file, flags); }, used_bits);
}

/// How many bits the values of `count` gray images of 16 bits use, over all of them: 8, 10, 12, 14 or 16; 16 for other
/// images, and where none can be read. `read(i, flags)` gives one.
template <class Read>
int used_gray_bits(std::size_t count, Read&& read) {
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i) {
    cv::Mat gray;
    try {
      gray = read(i, cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
    } catch (const std::runtime_error&) {
      continue;
    }
    if (gray.depth() != CV_16U) return 16;
    double value = 0;
    cv::minMaxLoc(gray, nullptr, &value);
    largest = std::max(largest, value);
  }
  for (const int bits : {8, 10, 12, 14})
    if (largest > 0 && largest < std::ldexp(1.0, bits)) return bits;
  return 16;
}

inline int used_gray_bits(const std::vector<std::filesystem::path>& files) {
  for (const std::filesystem::path& file : files)
    if (file.extension() == ".jpg" || file.extension() == ".jpeg") return 16;
  return used_gray_bits(files.size(), [&](std::size_t i, int flags) { return detail::read_image(files[i], flags); });
}

/// Depth as recorded, CV_16U, of what `read` gives for flags of cv::imread. Depth in meters (32-bit float) is
/// multiplied by `units_per_meter`, where that is not 0; what is not finite is 0, no measurement.
template <class Read>
cv::Mat depth_of(Read&& read, double units_per_meter, const std::filesystem::path& name) {
  cv::Mat depth = read(cv::IMREAD_ANYDEPTH | cv::IMREAD_ANYCOLOR);
  if (depth.type() == CV_32F && units_per_meter > 0) {
    cv::patchNaNs(depth, 0);
    depth.setTo(0, depth > 65535 / units_per_meter);  // infinity, too
    depth.convertTo(depth, CV_16U, units_per_meter);
  }
  if (depth.depth() == CV_8U)
    throw std::runtime_error(name.string() + ": an 8-bit image" + (depth.channels() > 1 ? " in color" : "") +
                             ": a picture of depth, not its values; 16 bits, or 32-bit float in meters, are read");
  if (depth.type() != CV_16U) throw std::runtime_error(name.string() + ": not a 16-bit image with one channel");
  return depth;
}

inline cv::Mat read_depth(const std::filesystem::path& file, double units_per_meter = 0) {
  return depth_of([&](int flags) { return detail::read_image(file, flags); }, units_per_meter, file);
}

/// Throws unless the image has the calibrated size.
inline void require_resolution(const cv::Mat& image, int width, int height, const std::filesystem::path& file) {
  const auto text = [](int w, int h) { return std::to_string(w) + " x " + std::to_string(h); };
  if (image.cols != width || image.rows != height)
    throw std::runtime_error(file.string() + ": the image is " + text(image.cols, image.rows) +
                             ", the calibration has " + text(width, height));
}

}  // namespace plumbline::opencv
