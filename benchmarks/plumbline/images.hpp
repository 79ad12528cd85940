#pragma once
/// The images of one frame of a recording.

#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"

struct Images {
  cv::Mat gray, depth;  ///< `depth` is empty where there is none
};

inline Images read_images(const plumbline::io::FrameSample& frame, bool with_depth) {
  Images out{plumbline::opencv::read_gray(frame.image), {}};
  if (with_depth && frame.depth) out.depth = plumbline::opencv::read_depth(*frame.depth);
  return out;
}
