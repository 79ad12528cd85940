#pragma once
/// The images of one frame of a recording, and whether they have the calibrated size.

#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"

struct Images {
  cv::Mat gray, depth;  ///< `depth` is empty where there is none
};

inline Images read_images(const plumbline::io::FrameSample& frame, bool with_depth) {
  Images out{plumbline::io::read_gray(frame), {}};
  if (with_depth && frame.depth) out.depth = plumbline::io::read_depth(frame);
  return out;
}

/// Throws std::runtime_error unless they have: a calibration for another size would give wrong poses without an error.
inline void require_calibrated_size(const plumbline::io::FrameSample& frame, const Images& images,
                                    const plumbline::io::CameraCalibration& camera) {
  using plumbline::opencv::require_resolution;
  require_resolution(images.gray, camera.width, camera.height, frame.image);
  if (!images.depth.empty()) require_resolution(images.depth, camera.width, camera.height, *frame.depth);
}
