#pragma once
/// cv::Mat seen as an ImageView, without a copy. The Mat must outlive the view.

#include <type_traits>

#include <opencv2/core/mat.hpp>

#include "plumbline/image/image_view.hpp"

namespace plumbline::opencv {

/// View of a single-channel image; empty when the element type is not `Pixel`.
template <class Pixel>
ImageView<const Pixel> view(const cv::Mat& image) {
  if (image.type() != cv::traits::Type<std::remove_const_t<Pixel>>::value) return {};
  return {image.ptr<Pixel>(), image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step1())};
}

}  // namespace plumbline::opencv
