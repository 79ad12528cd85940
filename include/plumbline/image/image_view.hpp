#pragma once
/// A non-owning view of a row-major image: the caller keeps the pixels alive. Pixel (0,0) is the CENTER of the top left
/// pixel. `stride` is the distance of two rows in pixels, so that a view may be a part of a larger image.

#include <cmath>
#include <cstddef>
#include <type_traits>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <class Pixel>
struct ImageView {
  Pixel* data = nullptr;
  int width = 0;              ///< [px]
  int height = 0;             ///< [px]
  std::ptrdiff_t stride = 0;  ///< [px]

  bool empty() const { return data == nullptr || width <= 0 || height <= 0; }
  Pixel* row(int y) const {
    PLUMBLINE_ASSERT(y >= 0 && y < height);
    return data + y * stride;
  }
  Pixel& operator()(int x, int y) const {
    PLUMBLINE_ASSERT(x >= 0 && x < width);
    return row(y)[x];
  }

  /// True when (x, y) keeps `border` pixels to every side; false for NaN too.
  template <class S>
  bool contains(S x, S y, S border) const {
    return x >= border && y >= border && x <= S(width - 1) - border && y <= S(height - 1) - border;
  }

  operator ImageView<const Pixel>() const requires(!std::is_const_v<Pixel>) { return {data, width, height, stride}; }
};

/// Bilinear interpolation at (x, y) [px]; the four neighbors must be inside.
template <class Pixel, class S>
S interpolate(const ImageView<Pixel>& image, S x, S y) {
  const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);  // rounds down what is not negative
  PLUMBLINE_ASSERT(x >= S(0) && y >= S(0) && x0 + 1 < image.width && y0 + 1 < image.height);
  const S ax = x - S(x0), ay = y - S(y0);
  const Pixel* top = image.row(y0) + x0;
  const Pixel* bottom = top + image.stride;
  return (S(1) - ay) * ((S(1) - ax) * S(top[0]) + ax * S(top[1])) +
         ay * ((S(1) - ax) * S(bottom[0]) + ax * S(bottom[1]));
}

}  // namespace plumbline
