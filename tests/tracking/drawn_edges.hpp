#pragma once
// Images of bright quadrilaterals with known edges, anti-aliased by 8x8 samples a pixel.

#include <array>
#include <cmath>

#include <opencv2/core.hpp>

#include "plumbline/core/matrix.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline::testing {

/// Corners in order, clockwise as seen: the inside is to the right of each edge.
struct Quadrilateral {
  std::array<Vec<float, 2>, 4> corner;

  static Quadrilateral rectangle(const Vec<float, 2>& center, float width, float height, float angle_rad) {
    const Vec<float, 2> u(0.5f * width * std::cos(angle_rad), 0.5f * width * std::sin(angle_rad));
    const Vec<float, 2> v(-0.5f * height * std::sin(angle_rad), 0.5f * height * std::cos(angle_rad));
    return {{Vec<float, 2>(center - u - v), Vec<float, 2>(center + u - v), Vec<float, 2>(center + u + v),
             Vec<float, 2>(center - u + v)}};
  }
  /// Edge k; the bright inside is on the side of its normal.
  LineSegment edge(std::size_t k) const { return {corner[k], corner[(k + 1) % 4], 0}; }

  bool contains(const Vec<float, 2>& uv) const {
    for (std::size_t k = 0; k < 4; ++k) {
      if (edge(k).distance(uv) < 0) return false;
    }
    return true;
  }
};

/// Calls `paint(pixel, part of it inside)` for the pixels of the shape.
inline void for_each_pixel(cv::Mat& image, const Quadrilateral& shape, auto&& paint) {
  constexpr int samples = 8;
  for (int y = 0; y < image.rows; ++y) {
    for (int x = 0; x < image.cols; ++x) {
      int inside = 0;
      const Vec<float, 2> center(static_cast<float>(x), static_cast<float>(y));
      float nearest = 2;  // pixels far from all edges need one sample
      for (std::size_t k = 0; k < 4; ++k) nearest = std::min(nearest, std::abs(shape.edge(k).distance(center)));
      if (nearest >= 2) {
        inside = samples * samples * shape.contains(center);
      } else {
        for (int s = 0; s < samples * samples; ++s) {
          const Vec<float, 2> offset(static_cast<float>(s % samples), static_cast<float>(s / samples));
          inside += shape.contains(center + (offset / samples).array().matrix() -
                                   Vec<float, 2>::Constant(0.5f - 0.5f / samples));
        }
      }
      paint(image.at<float>(y, x), static_cast<float>(inside) / (samples * samples));
    }
  }
}

/// Adds `contrast` inside of the shape.
inline void draw(cv::Mat& image, const Quadrilateral& shape, float contrast) {
  for_each_pixel(image, shape, [&](float& pixel, float inside) { pixel += contrast * inside; });
}

/// Covers what is there.
inline void cover(cv::Mat& image, const Quadrilateral& shape, float intensity) {
  for_each_pixel(image, shape, [&](float& pixel, float inside) { pixel += inside * (intensity - pixel); });
}

/// Angle between two segments with direction [rad].
inline float angle_between(const LineSegment& a, const LineSegment& b) {
  const Vec<float, 2> p = a.direction(), q = b.direction();
  return std::abs(std::atan2(p.x() * q.y() - p.y() * q.x(), p.dot(q)));
}

}  // namespace plumbline::testing
