#pragma once
/// The pixels of image messages, as files of the same images would give them.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "plumbline/io/bag/messages.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace plumbline::io::bag {

namespace detail {

/// What an encoding is in OpenCV's types, and the conversion to gray, where it has colors.
struct PixelFormat {
  int type;
  std::optional<int> to_gray, to_bgr;
};

inline std::optional<PixelFormat> pixel_format(std::string_view encoding) {
  if (encoding == "mono8" || encoding == "8UC1") return PixelFormat{CV_8UC1, {}, {}};
  if (encoding == "bgr8" || encoding == "8UC3") return PixelFormat{CV_8UC3, cv::COLOR_BGR2GRAY, {}};
  if (encoding == "rgb8") return PixelFormat{CV_8UC3, cv::COLOR_RGB2GRAY, cv::COLOR_RGB2BGR};
  if (encoding == "bgra8") return PixelFormat{CV_8UC4, cv::COLOR_BGRA2GRAY, cv::COLOR_BGRA2BGR};
  if (encoding == "rgba8") return PixelFormat{CV_8UC4, cv::COLOR_RGBA2GRAY, cv::COLOR_RGBA2BGR};
  if (encoding == "mono16" || encoding == "16UC1") return PixelFormat{CV_16UC1, {}, {}};
  if (encoding == "32FC1") return PixelFormat{CV_32FC1, {}, {}};
  return std::nullopt;
}

inline void swap_bytes(cv::Mat& image) {
  const std::size_t size = image.elemSize1();
  for (int y = 0; y < image.rows; ++y)
    for (std::uint8_t *at = image.ptr(y), *end = at + static_cast<std::size_t>(image.cols) * size; at != end;
         at += size)
      for (std::size_t i = 0; i < size / 2; ++i) std::swap(at[i], at[size - 1 - i]);
}

}  // namespace detail

/// Whether the encoding is one of depth: meters as float, or 16 bits that are not called gray.
inline bool is_depth_encoding(std::string_view encoding) { return encoding == "16UC1" || encoding == "32FC1"; }

/// `flags` are those of cv::imread: gray of 8 bits, gray of any depth, or any depth and color. Throws
/// std::runtime_error without a name.
inline cv::Mat pixels_of(const ImageMessage& message, int flags) {
  const std::optional<detail::PixelFormat> format = detail::pixel_format(message.encoding);
  if (!format)
    throw std::runtime_error("the encoding \"" + message.encoding +
                             "\" is not read; read are mono8, bgr8, rgb8, bgra8, rgba8, mono16, 16UC1 and 32FC1");
  constexpr std::uint32_t largest = 1 << 15;
  const std::uint64_t width = message.width, height = message.height, step = message.step;
  const std::uint64_t row = width * static_cast<std::uint64_t>(CV_ELEM_SIZE(format->type));
  if (width == 0 || height == 0 || width > largest || height > largest || step < row ||
      message.data.size() < (height - 1) * step + row)
    throw std::runtime_error("an image of " + std::to_string(width) + " x " + std::to_string(height) + ", " +
                             message.encoding + ", in rows of " + std::to_string(step) + " bytes needs more than its " +
                             std::to_string(message.data.size()) + " bytes");
  const cv::Mat borrowed(static_cast<int>(height), static_cast<int>(width), format->type,
                         const_cast<std::uint8_t*>(message.data.data()), static_cast<std::size_t>(step));
  cv::Mat image = borrowed.clone();  // the bytes are gone with the next message
  if (image.elemSize1() > 1 && message.is_bigendian == (std::endian::native == std::endian::little))
    detail::swap_bytes(image);
  const bool is_gray = flags == cv::IMREAD_GRAYSCALE || flags == (cv::IMREAD_GRAYSCALE | cv::IMREAD_ANYDEPTH);
  if (is_gray && format->to_gray) cv::cvtColor(image, image, *format->to_gray);
  if (!is_gray && format->to_bgr) cv::cvtColor(image, image, *format->to_bgr);
  if (flags == cv::IMREAD_GRAYSCALE && image.depth() == CV_16U) {
    cv::Mat upper(image.size(), CV_8U);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) upper.at<std::uint8_t>(y, x) = image.at<std::uint16_t>(y, x) >> 8;
    return upper;
  }
  if (flags == cv::IMREAD_GRAYSCALE && image.depth() == CV_32F)
    throw std::runtime_error("the encoding 32FC1 is that of depth");
  return image;
}

/// The JPEG or PNG in a message. image_transport puts twelve bytes of its own before that of depth ("compressedDepth");
/// floating-point depth it writes as its inverse, in steps that these bytes state. Throws std::runtime_error of that.
inline Bytes file_in(const CompressedImageMessage& message) {
  constexpr std::size_t head = 12;
  const bool has_head = message.format.find("compressedDepth") != message.format.npos;
  if (has_head && message.format.starts_with("32FC1"))
    throw std::runtime_error("the format \"" + message.format + "\" is not read: record 16UC1, or depth as it is");
  return has_head && message.data.size() > head ? message.data.subspan(head) : message.data;
}

}  // namespace plumbline::io::bag
