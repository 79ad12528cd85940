#pragma once
/// The images of one frame of a recording.

#include "plumbline/io/recording.hpp"

struct Images {
  cv::Mat gray, depth;  ///< `depth` is empty where there is none
};

inline Images read_images(const plumbline::io::FrameSample& frame, bool with_depth) {
  Images out{plumbline::io::read_gray(frame), {}};
  if (with_depth && frame.depth) out.depth = plumbline::io::read_depth(frame);
  return out;
}
