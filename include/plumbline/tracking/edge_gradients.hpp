#pragma once
/// Image gradients at the few pixels that are asked for, computed there and then.           docs/math/line.md (18)
///
/// An edge that is followed from frame to frame is looked at on a few normals: that is a tenth of the image's pixels,
/// so that nothing needs a map of all.

#include <cstddef>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_mask.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/edge_queries.hpp"

namespace plumbline {

class EdgeGradients : public EdgeQueries<EdgeGradients> {
 public:
  /// The pixels must outlive it; those that the mask excludes have no gradient. Contains nothing where the image is too
  /// small to have an inside.
  explicit EdgeGradients(const ImageView<const std::uint8_t>& image, const MaskView& mask = {})
      : image_(image), mask_(mask) {
    if (image.empty() || image.width <= 2 * border || image.height <= 2 * border || image.width > max_side ||
        image.height > max_side)
      return;
    width_ = image.width;
    height_ = image.height;
  }

  EdgeGradient gradient(int x, int y) const {
    const bool inside = x >= border && y >= border && x < width_ - border && y < height_ - border;
    return inside ? gradient_inside(x, y) : EdgeGradient{0, 0};
  }
  /// Not inlined: by itself GCC makes packets of it, a third fewer instructions.
  EIGEN_DONT_INLINE EdgeGradient gradient_inside(int x, int y) const {
    if (mask_.excludes(x, y)) return {0, 0};
    // Eight columns instead of five, which are a packet: those beyond have no weight, and are in the image's memory
    // because there is a row below.
    constexpr int n = 8;
    constexpr std::int16_t mean[n] = {1, 4, 6, 4, 1, 0, 0, 0}, difference[n] = {-1, -2, 0, 2, 1, 0, 0, 0};
    std::int16_t row[5][n], smooth[n], slope[n];  // of the columns
    for (int v = 0; v < 5; ++v) {
      const std::uint8_t* const pixels = image_.data + (y + v - 2) * image_.stride + x - 2;
      for (int k = 0; k < n; ++k) row[v][k] = pixels[k];
    }
    for (int k = 0; k < n; ++k) {
      smooth[k] = static_cast<std::int16_t>(row[0][k] + row[4][k] + 4 * (row[1][k] + row[3][k]) + 6 * row[2][k]);
      slope[k] = static_cast<std::int16_t>(row[4][k] - row[0][k] + 2 * (row[3][k] - row[1][k]));
    }
    int gx = 0, gy = 0;
    for (int k = 0; k < n; ++k) {
      gx += difference[k] * smooth[k];
      gy += mean[k] * slope[k];
    }
    return {static_cast<std::int16_t>(gx), static_cast<std::int16_t>(gy)};
  }

 private:
  static constexpr int max_side = 32000;  ///< [px], of EdgePixel

  ImageView<const std::uint8_t> image_;
  MaskView mask_;
};

}  // namespace plumbline
