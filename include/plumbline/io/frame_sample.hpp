#pragma once
/// A frame of a recording, its images by name: files, or what another source of images has under a number.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <opencv2/core.hpp>

#include "plumbline/core/time.hpp"
#include "plumbline/io/image_scale.hpp"
#include "plumbline/opencv/image_file.hpp"

namespace plumbline::io {

/// Images that are no files of their own, e.g. messages of a bag.
class ImageSource {
 public:
  ImageSource() = default;
  ImageSource(const ImageSource&) = delete;
  ImageSource& operator=(const ImageSource&) = delete;
  virtual ~ImageSource() = default;
  /// `flags` are those of cv::imread. Throws std::runtime_error "name: what is wrong".
  virtual cv::Mat read(std::size_t image, int flags) = 0;
};

struct FrameSample {
  TimeNs t_ns = 0;
  std::filesystem::path image;  ///< a file, or the name of what `source` has
  std::optional<std::filesystem::path> depth;
  int gray_bits = 16;                   ///< that the values of 16-bit gray images use
  double depth_scale = 0;               ///< of the calibration: for depth images in meters
  double image_scale = 1;               ///< of both images, when they are read
  std::shared_ptr<ImageSource> source;  ///< empty: the images are files
  std::size_t image_number = 0, depth_number = 0;
};

/// 8-bit gray. Throws std::runtime_error that names the image.
inline cv::Mat read_gray(const FrameSample& frame) {
  const auto from_source = [&](int flags) { return frame.source->read(frame.image_number, flags); };
  const cv::Mat gray =
      frame.source ? opencv::gray_of(from_source, frame.gray_bits) : opencv::read_gray(frame.image, frame.gray_bits);
  return frame.image_scale == 1 ? gray : scaled_gray(gray, frame.image_scale);
}

/// Raw depth of 16 bits; `frame.depth` must be there. Throws std::runtime_error that names the image.
inline cv::Mat read_depth(const FrameSample& frame) {
  const auto from_source = [&](int flags) { return frame.source->read(frame.depth_number, flags); };
  const cv::Mat depth = frame.source ? opencv::depth_of(from_source, frame.depth_scale, *frame.depth)
                                     : opencv::read_depth(*frame.depth, frame.depth_scale);
  return frame.image_scale == 1 ? depth : scaled_depth(depth, frame.image_scale);
}

/// How many bits the values of these images use (opencv::used_gray_bits).
inline int used_gray_bits(const std::vector<FrameSample>& frames) {
  if (frames.empty() || !frames.front().source) {
    std::vector<std::filesystem::path> files;
    files.reserve(frames.size());
    for (const FrameSample& frame : frames) files.push_back(frame.image);
    return opencv::used_gray_bits(files);
  }
  return opencv::used_gray_bits(
      frames.size(), [&](std::size_t i, int flags) { return frames[i].source->read(frames[i].image_number, flags); });
}

}  // namespace plumbline::io
