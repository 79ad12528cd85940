#pragma once
/// Segments of two images paired by LBD, the line band descriptor of L. Zhang and R. Koch (2013), in the binary form of
/// OpenCV's contributed module line_descriptor (target plumbline::lbd).
///
///   const std::vector<LineMatch> matches = match_lines_lbd(image, segments, other_image, other_segments);
///
/// The descriptor sums gradients along and across the segment in 9 bands of 7 px to both sides; its bits compare bands.
/// Segments may come from any detector.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/line_descriptor.hpp>

#include "plumbline/image/image_view.hpp"
#include "plumbline/opencv/line_matching.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline::opencv {

/// One for each segment, in their order. The image must not be empty.
inline std::vector<LineDescriptor> lbd_descriptors(const ImageView<const std::uint8_t>& image,
                                                   std::span<const LineSegment> segments) {
  std::vector<LineDescriptor> out(segments.size());
  if (segments.empty()) return out;
  std::vector<cv::line_descriptor::KeyLine> lines;
  for (const LineSegment& s : segments) {
    cv::line_descriptor::KeyLine line{};
    line.startPointX = line.sPointInOctaveX = s.start.x();
    line.startPointY = line.sPointInOctaveY = s.start.y();
    line.endPointX = line.ePointInOctaveX = s.end.x();
    line.endPointY = line.ePointInOctaveY = s.end.y();
    line.angle = std::atan2(s.end.y() - s.start.y(), s.end.x() - s.start.x());
    line.lineLength = s.length();
    line.numOfPixels = static_cast<int>(std::lround(s.length()));
    line.class_id = static_cast<int>(lines.size());  // the row of its descriptor
    lines.push_back(line);
  }
  cv::Mat rows;
  cv::line_descriptor::BinaryDescriptor::createBinaryDescriptor()->compute(mat(image), lines, rows);
  CV_Assert(rows.rows == static_cast<int>(out.size()) && rows.cols * rows.elemSize() == sizeof(LineDescriptor));
  for (std::size_t i = 0; i < out.size(); ++i) std::memcpy(&out[i], rows.ptr(static_cast<int>(i)), sizeof(out[i]));
  return out;
}

/// Pairs in the order of the first image's segments; no segment is in two of them.
inline std::vector<LineMatch> match_lines_lbd(const ImageView<const std::uint8_t>& first_image,
                                              std::span<const LineSegment> first,
                                              const ImageView<const std::uint8_t>& second_image,
                                              std::span<const LineSegment> second,
                                              const LineMatchOptions& options = {}) {
  return match_lines(first, lbd_descriptors(first_image, first), second, lbd_descriptors(second_image, second),
                     options);
}

}  // namespace plumbline::opencv
