#pragma once
/// Images that are scaled down when they are read, and the camera that has taken such images.
///
/// The center of the pixel (0, 0) is at u = v = 0. An image of w x h pixels scaled to w' x h' has
///   u' + 1/2 = (u + 1/2) w'/w,   v' + 1/2 = (v + 1/2) h'/h.                                                 (1)

#include <algorithm>
#include <cmath>
#include <cstddef>

#include <opencv2/imgproc.hpp>

#include "plumbline/io/calibration_data.hpp"

namespace plumbline::io {

/// Of an image's width or height [px].
inline int scaled_size(int size, double scale) { return std::max(1, static_cast<int>(std::lround(size * scale))); }

/// The camera of the scaled images, by (1).
inline void scale_camera(double scale, CameraCalibration& camera) {
  const int width = scaled_size(camera.width, scale), height = scaled_size(camera.height, scale);
  const double by_u = static_cast<double>(width) / camera.width, by_v = static_cast<double>(height) / camera.height;
  camera.intrinsics[0] *= by_u;
  camera.intrinsics[1] *= by_v;
  camera.intrinsics[2] = (camera.intrinsics[2] + 0.5) * by_u - 0.5;
  camera.intrinsics[3] = (camera.intrinsics[3] + 0.5) * by_v - 0.5;
  camera.width = width;
  camera.height = height;
}

/// 1/n, the largest that leaves no more than `max_pixels` of the image; 1 for max_pixels 0.
inline double fitting_scale(const CameraCalibration& camera, std::size_t max_pixels) {
  const double pixels = static_cast<double>(camera.width) * camera.height, room = static_cast<double>(max_pixels);
  return max_pixels == 0 || pixels <= room ? 1 : 1 / std::ceil(std::sqrt(pixels / room));
}

/// Means of the pixels.
inline cv::Mat scaled_gray(const cv::Mat& gray, double scale) {
  cv::Mat out;
  cv::resize(gray, out, {scaled_size(gray.cols, scale), scaled_size(gray.rows, scale)}, 0, 0, cv::INTER_AREA);
  return out;
}
/// Measured values, not means, which would be wrong at the contours of objects.
inline cv::Mat scaled_depth(const cv::Mat& depth, double scale) {
  cv::Mat out;
  cv::resize(depth, out, {scaled_size(depth.cols, scale), scaled_size(depth.rows, scale)}, 0, 0,
             cv::INTER_NEAREST_EXACT);
  return out;
}

}  // namespace plumbline::io
