#pragma once
/// Queries of image gradients at single pixels: derivative along a normal, and the peak of an edge.
///                                                                                          docs/math/line.md
/// `Gradients` is EdgeMap, which holds those of the whole image, or EdgeGradients, which computes the few that are
/// requested; both give the same numbers. It has gradient(x, y), (18) inside of a border and zero on it, and
/// gradient_inside(x, y) for callers that ensure that it is inside.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

struct EdgePixel {
  std::int16_t x, y;
};

/// (18) [intensity/px / 128]
struct EdgeGradient {
  std::int16_t x, y;
  int strength() const { return std::abs(x) + std::abs(y); }
  /// The edge through the pixel is steeper than 45 degrees.
  bool is_steep() const { return std::abs(x) >= std::abs(y); }
};

/// The pixel that a position [px] >= 0 is in.
inline EdgePixel nearest_pixel(const Vec<float, 2>& uv) {
  return {static_cast<std::int16_t>(uv.x() + 0.5f), static_cast<std::int16_t>(uv.y() + 0.5f)};  // rounds down
}

template <class Gradients>
class EdgeQueries {
 public:
  static constexpr float units = 128;  ///< of (18), for one gray level per pixel
  static constexpr int border = 3;     ///< pixels at the edge of the image that have no strength

  int width() const { return width_; }
  int height() const { return height_; }
  /// True when the position is inside of the border; false for NaN.
  bool contains(const Vec<float, 2>& uv) const {
    return uv.x() >= float(border) && uv.y() >= float(border) && uv.x() < static_cast<float>(width_ - border) - 0.5f &&
           uv.y() < static_cast<float>(height_ - border) - 0.5f;
  }

  /// Derivative along the unit normal at the nearest pixel [intensity/px], 0 where the gradient is more than 22.5
  /// degrees off the normal, and outside.
  float aligned_slope(const Vec<float, 2>& uv, const Vec<float, 2>& normal) const {
    return contains(uv) ? slope_inside(uv, normal) : 0.0f;
  }
  /// The same at `at` + j `normal`, j = -range ... range, into out[j + range].
  void aligned_slopes(const Vec<float, 2>& at, const Vec<float, 2>& normal, int range, float* out) const {
    const Vec<float, 2> first = at - static_cast<float>(range) * normal, last = at + static_cast<float>(range) * normal;
    const bool inside = contains(first) && contains(last);
    for (int j = 0; j <= 2 * range; ++j) {
      const Vec<float, 2> uv = first + static_cast<float>(j) * normal;
      out[j] = inside ? slope_inside(uv, normal) : aligned_slope(uv, normal);
    }
  }

  /// Where the strength peaks across the edge near the pixel: the vertex of a parabola.
  Vec<float, 2> peak(const EdgePixel& pixel) const {
    const EdgeGradient gradient = at(pixel.x, pixel.y);
    const bool steep = gradient.is_steep();
    const int dx = steep ? 1 : 0, dy = 1 - dx;
    const int before = at(pixel.x - dx, pixel.y - dy).strength(), here = gradient.strength(),
              after = at(pixel.x + dx, pixel.y + dy).strength();
    const int curvature = 2 * here - before - after;
    float shift = 0;
    if (curvature > 0)
      shift = std::clamp(0.5f * static_cast<float>(after - before) / static_cast<float>(curvature), -1.0f, 1.0f);
    const Vec<float, 2> center(pixel.x, pixel.y);
    return center + (steep ? Vec<float, 2>(shift, 0) : Vec<float, 2>(0, shift));
  }

 protected:
  int width_ = 0, height_ = 0;

 private:
  EdgeGradient at(int x, int y) const { return static_cast<const Gradients&>(*this).gradient(x, y); }

  float slope_inside(const Vec<float, 2>& uv, const Vec<float, 2>& normal) const {
    const EdgePixel pixel = nearest_pixel(uv);
    const EdgeGradient gradient = static_cast<const Gradients&>(*this).gradient_inside(pixel.x, pixel.y);
    const float u = static_cast<float>(gradient.x), v = static_cast<float>(gradient.y);
    const float across = normal.x() * u + normal.y() * v, along = normal.x() * v - normal.y() * u;
    constexpr float tan_22_5 = 0.41421356f;
    return std::abs(along) < tan_22_5 * across ? across / units : 0.0f;
  }
};

}  // namespace plumbline
