#pragma once
/// Corners for tracking: FAST-9 finds them, Shi-Tomasi ranks them, a grid spreads them.    docs/math/tracking.md
///
/// FAST-9: 9 contiguous pixels of the 16 on a circle of radius 3 are all brighter than I + t or all darker than I - t.
///   score = smallest eigenvalue of  1/49 sum g g^T  over 7x7 pixels,  g = central differences  [intensity^2/px^2] (11)
/// Each grid cell without a feature gives at most its best corner that keeps half a cell of distance to all features.
/// A cell where the high threshold finds none is searched again with the low one, and where that finds none either
/// (nearly white walls) the best-scored pixel of the cell is taken, so that only noise (`min_score`) is left out.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_mask.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/corner_score.hpp"
#include "plumbline/tracking/fast_contrast.hpp"

namespace plumbline {

struct Corner {
  Vec<float, 2> uv;  ///< [px] of level 0
  float score;       ///< (11)
  int level;         ///< of the pyramid it was found on: 0
};

struct CornerOptions {
  int cell_px = 30;
  int fast_threshold = 20;     ///< [intensity]
  int fast_threshold_low = 7;  ///< for cells where the high one finds nothing [intensity]
  float min_score = 2.0f;      ///< (11) of the weakest corner: above the camera's noise
  int border_px = 16;          ///< no corner nearer to the image's edge; at least 4
};

/// The best corner of the cell [x0, x1) x [y0, y1) among those at least `distance_px` from all `near` features and not
/// excluded by the mask: one of FAST with the high threshold, else with the low one, else any pixel. Score 0 when there
/// is none.
template <std::size_t Near>
Corner best_corner(const ImageView<const std::uint8_t>& image, int x0, int y0, int x1, int y1,
                   const FixedVector<Vec<float, 2>, Near>& near, float distance_px, const CornerOptions& options,
                   const MaskView& mask = {}) {
  const FastContrast fast(image.stride);
  const auto is_free = [&](const Vec<float, 2>& uv) {
    return !mask.excludes(uv) && std::none_of(near.begin(), near.end(), [&](const Vec<float, 2>& other) {
      return squared_norm(other - uv) < distance_px * distance_px;
    });
  };
  Corner best{zeros<float, 2>(), 0.0f, 0};
  int best_grade = 0;  // 1: any pixel, 2: FAST with the low threshold, 3: with the high one
  ScoreTile scores;
  for (int tile_y = y0; tile_y < y1; tile_y += ScoreTile::size) {
    for (int tile_x = x0; tile_x < x1; tile_x += ScoreTile::size) {
      // The last tile is moved back into the image.
      const int left = std::min(tile_x, image.width - ScoreTile::size - ScoreTile::margin);
      const int top = std::min(tile_y, image.height - ScoreTile::size - ScoreTile::margin);
      const int bottom = std::min(tile_y + ScoreTile::size, y1);
      scores.compute(image, left, top, bottom - top);
      for (int y = tile_y; y < bottom; ++y) {
        const ScoreTile::Row& row = scores.row(y - top);
        const float row_best = row.maxCoeff();
        if (!(row_best >= options.min_score)) continue;
        const std::uint8_t* pixels = image.data + y * image.stride + left;
        const auto grade_of = [&](int contrast) {
          return 1 + (contrast > options.fast_threshold_low) + (contrast > options.fast_threshold);
        };
        const bool may_be_stronger = row_best > best.score;
        if (best_grade == 3 && !may_be_stronger) continue;
        if (grade_of(fast.bound_of_row<ScoreTile::size>(pixels)) < best_grade + !may_be_stronger) continue;
        const std::array<std::uint8_t, ScoreTile::size> contrasts = fast.of_row<ScoreTile::size>(pixels);
        for (int x = tile_x - left; x < std::min(tile_x + ScoreTile::size, x1) - left; ++x) {
          if (!(row[x] >= options.min_score)) continue;
          const int grade = grade_of(contrasts[static_cast<std::size_t>(x)]);
          const bool stronger = row[x] > best.score;
          if (grade < best_grade + !stronger) continue;
          const Vec<float, 2> uv(static_cast<float>(left + x), static_cast<float>(y));
          if (!is_free(uv)) continue;
          best = {uv, row[x], 0};
          best_grade = grade;
        }
      }
    }
  }
  return best;
}

/// Appends to `out` new corners beside the `existing` features [px of level 0], best first; when `out` is too small the
/// weakest are left out. None is at a pixel that the mask excludes. Images smaller than 40 px give none.
template <std::size_t N>
void detect_corners(ImageView<const std::uint8_t> image, const Vec<float, 2>* existing, std::size_t n_existing,
                    const CornerOptions& options, FixedVector<Corner, N>& out, const MaskView& mask = {}) {
  PLUMBLINE_ASSERT(options.cell_px > 0 && options.border_px >= 4);
  constexpr int smallest = ScoreTile::size + 2 * ScoreTile::margin;
  if (image.empty() || image.width < smallest || image.height < smallest) return;
  const std::size_t first = out.size();
  const auto weaker = [](const Corner& a, const Corner& b) { return a.score > b.score; };  // for a heap, worst on top
  const float distance_px = 0.5f * static_cast<float>(options.cell_px);
  for (int y0 = options.border_px; y0 < image.height - options.border_px; y0 += options.cell_px) {
    const int y1 = std::min(y0 + options.cell_px, image.height - options.border_px);
    for (int x0 = options.border_px; x0 < image.width - options.border_px; x0 += options.cell_px) {
      const int x1 = std::min(x0 + options.cell_px, image.width - options.border_px);
      // Features in the cell, and those around it to keep the distance to.
      FixedVector<Vec<float, 2>, 32> near;
      bool occupied = false;
      const auto note = [&](const Vec<float, 2>& uv) {
        const float dy = std::max({static_cast<float>(y0) - uv.y(), 0.0f, uv.y() - static_cast<float>(y1 - 1)});
        if (!(dy < distance_px)) return;
        const float dx = std::max({static_cast<float>(x0) - uv.x(), 0.0f, uv.x() - static_cast<float>(x1 - 1)});
        if (dx < distance_px) occupied |= (dx < 0.5f && dy < 0.5f) || !near.push_back(uv);
      };
      for (std::size_t i = 0; i < n_existing && !occupied; ++i) note(existing[i]);
      for (std::size_t i = first; i < out.size() && !occupied; ++i) note(out[i].uv);
      if (occupied) continue;
      const Corner best = best_corner(image, x0, y0, x1, y1, near, distance_px, options, mask);
      if (!(best.score > 0.0f)) continue;
      if (out.full()) {
        if (out.size() == first || !(best.score > out[first].score)) continue;
        std::pop_heap(out.begin() + first, out.end(), weaker);
        out.pop_back();
      }
      out.push_back(best);
      std::push_heap(out.begin() + first, out.end(), weaker);
    }
  }
  std::sort(out.begin() + first, out.end(), weaker);
}

}  // namespace plumbline
