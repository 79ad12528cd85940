#pragma once
/// cv::Mat seen as an ImageView and the other way round, without a copy. What owns the pixels must outlive the other.

#include <cstddef>
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

/// Header of a view, for functions of OpenCV that only read.
template <class Pixel>
cv::Mat mat(const ImageView<const Pixel>& image) {
  if (image.empty()) return {};
  return {image.height, image.width, cv::traits::Type<Pixel>::value, const_cast<Pixel*>(image.data),
          static_cast<std::size_t>(image.stride) * sizeof(Pixel)};
}

}  // namespace plumbline::opencv
