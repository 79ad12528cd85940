#include "mask.hpp"

#include <stdexcept>
#include <string>

#include <opencv2/core.hpp>

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
  plumbline::opencv::require_resolution(mask, calibration.camera.width, calibration.camera.height, name);
  const int used = cv::countNonZero(mask);
  if (used == 0) throw std::runtime_error(name + ": excludes all of the image: every pixel is zero");
  if (used == mask.rows * mask.cols)
    throw std::runtime_error(name + ": excludes nothing: no pixel is zero (zero is what is not used)");
  return mask;
}
