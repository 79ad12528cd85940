#include "mask.hpp"

#include <stdexcept>
#include <string>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "plumbline/io/image_scale.hpp"
#include "plumbline/opencv/image_file.hpp"

cv::Mat read_mask(const plumbline::io::Calibration& calibration) {
  if (!calibration.mask) return {};
  const std::string name = "mask " + calibration.mask->string();
  cv::Mat mask;
  try {
    mask = plumbline::opencv::read_gray(*calibration.mask);
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(std::string("mask ") + error.what());
  }
  if (calibration.image_scale != 1) {  // what is excluded in part is excluded
    cv::threshold(mask, mask, 0, 255, cv::THRESH_BINARY);
    mask = plumbline::io::scaled_gray(mask, calibration.image_scale) == 255;
  }
  plumbline::opencv::require_resolution(mask, calibration.camera.width, calibration.camera.height, name);
  const int used = cv::countNonZero(mask);
  if (used == 0) throw std::runtime_error(name + ": excludes all of the image: every pixel is zero");
  if (used == mask.rows * mask.cols)
    throw std::runtime_error(name + ": excludes nothing: no pixel is zero (zero is what is not used)");
  return mask;
}
