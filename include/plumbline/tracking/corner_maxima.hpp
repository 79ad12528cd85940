#pragma once
/// Corners that are found again in another image: the strongest local maxima of the corner score.
///                                                                                docs/math/place_recognition.md
///   S(x, y) >= min_score,   S(x, y) > S(x', y')  for all |x' - x|, |y' - y| <= radius                           (2)
///   u = x + (S_+ - S_-) / (2 (2 S - S_+ - S_-)),  S_+- = S(x +- 1, y), v likewise: the vertex of a parabola
///   (2a)
/// S is the smallest eigenvalue of the structure tensor, corner_score.hpp. `detect_corners` (corner_detector.hpp) gives
/// every cell of a grid its corner instead: spread evenly for tracking, but found again less often. FAST is not asked:
/// the maximum of S is often beside the pixel that passes it.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/corner_score.hpp"

namespace plumbline {

struct CornerMaximaOptions {
  static constexpr int radius_px = 3;  ///< of the square in which a corner is the strongest
  float min_score = 1.0f;              ///< above the camera's noise [intensity^2/px^2]
  int border_px = 16;                  ///< no corner's pixel nearer to the image's edge; at least 8
  float distance_px = 6.0f;            ///< to the existing points
};

/// Puts the strongest corners (2) into `out`, the strongest one first, at most `limit` and as many as it holds. None is
/// near an `existing` point [px of this image], or where is_excluded(pixel of this image). Images smaller than 48 px
/// give none.
template <std::size_t N>
void detect_corner_maxima(const ImageView<const std::uint8_t>& image, std::span<const Vec<float, 2>> existing,
                          const CornerMaximaOptions& options, std::size_t limit, FixedVector<Corner, N>& out,
                          const auto& is_excluded) {
  constexpr int size = ScoreTile::size, margin = ScoreTile::margin, r = CornerMaximaOptions::radius_px;
  constexpr int step = size - 2 * r;  // of tiles: neighbors overlap by the square's radius
  PLUMBLINE_ASSERT(options.border_px >= margin + r + 1);
  out.clear();
  limit = std::min(limit, N);
  constexpr int smallest = size + 2 * margin + 8;
  if (image.empty() || image.width < smallest || image.height < smallest || limit == 0) return;
  const auto vertex = [](float before, float at, float after) {  // (2a), within half a pixel of a strict maximum
    return (after - before) / (2 * (2 * at - after - before));
  };
  const auto stronger = [](const Corner& a, const Corner& b) { return a.score > b.score; };  // heap: weakest on top
  const auto is_free = [&](const Vec<float, 2>& uv) {
    return !is_excluded(uv) && std::none_of(existing.begin(), existing.end(), [&](const Vec<float, 2>& other) {
      return squared_norm(other - uv) < options.distance_px * options.distance_px;
    });
  };
  const int right = image.width - options.border_px, bottom = image.height - options.border_px;
  ScoreTile scores;
  for (int y0 = options.border_px; y0 < bottom; y0 += step) {
    for (int x0 = options.border_px; x0 < right; x0 += step) {
      // The last tile is moved back into the image; it still covers the rest.
      const int left = std::min(x0 - r, image.width - size - margin),
                top = std::min(y0 - r, image.height - size - margin);
      scores.compute(image, left, top);
      for (int y = y0; y < std::min(y0 + step, bottom); ++y) {
        const float* const row = scores.row(y - top).data();
        if (!(scores.row(y - top).maxCoeff() >= options.min_score)) continue;
        for (int x = x0 - left; x < std::min(x0 + step, right) - left; ++x) {
          const float score = row[x];
          if (!(score >= options.min_score) || score <= row[x - 1] || score <= row[x + 1]) continue;
          if (out.size() == limit && score <= out[0].score) continue;
          bool is_maximum = true;
          for (int dy = -r; dy <= r && is_maximum; ++dy) {
            const float* const other = scores.row(y + dy - top).data();
            for (int dx = -r; dx <= r; ++dx) is_maximum = is_maximum && (other[x + dx] < score || (dx == 0 && dy == 0));
          }
          if (!is_maximum) continue;
          const Vec<float, 2> uv(
              static_cast<float>(left + x) + vertex(row[x - 1], score, row[x + 1]),
              static_cast<float>(y) + vertex(scores.row(y - 1 - top)[x], score, scores.row(y + 1 - top)[x]));
          if (!is_free(uv)) continue;
          if (out.size() == limit) {
            std::pop_heap(out.begin(), out.end(), stronger);
            out.pop_back();
          }
          out.push_back({uv, score, 0});
          std::push_heap(out.begin(), out.end(), stronger);
        }
      }
    }
  }
  std::sort(out.begin(), out.end(), stronger);
}

template <std::size_t N>
void detect_corner_maxima(const ImageView<const std::uint8_t>& image, std::span<const Vec<float, 2>> existing,
                          const CornerMaximaOptions& options, std::size_t limit, FixedVector<Corner, N>& out) {
  detect_corner_maxima(image, existing, options, limit, out, [](const Vec<float, 2>&) { return false; });
}

}  // namespace plumbline
