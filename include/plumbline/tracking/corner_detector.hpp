#pragma once
/// Corners for tracking: FAST-9 finds them, Shi-Tomasi ranks them, a grid spreads them.    docs/math/tracking.md
///
/// FAST-9: 9 contiguous pixels of the 16 on a circle of radius 3 are all brighter than I + t or all darker than I - t.
///   score = smallest eigenvalue of  1/49 sum g g^T  over 7x7 pixels,  g = central differences  [intensity^2/px^2] (11)
/// Each grid cell without a feature gives at most its best corner that keeps half a cell of distance to all features.
/// A cell where the high threshold finds none is searched again with the low one, and where that finds none either
/// (nearly white walls) the best-scored pixel of the cell stands in, so that only noise (`min_score`) is left out.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"

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

/// (11) at a pixel at least 4 px inside.
inline float min_eigenvalue_score(const ImageView<const std::uint8_t>& image, int x, int y) {
  constexpr int radius = 3, samples = (2 * radius + 1) * (2 * radius + 1);
  int xx = 0, xy = 0, yy = 0;
  for (int v = y - radius; v <= y + radius; ++v) {
    const std::uint8_t* row = image.data + v * image.stride;
    for (int u = x - radius; u <= x + radius; ++u) {
      const int gx = row[u + 1] - row[u - 1], gy = row[u + image.stride] - row[u - image.stride];
      xx += gx * gx;
      xy += gx * gy;
      yy += gy * gy;
    }
  }
  const float mean = 0.5f * static_cast<float>(xx + yy), half_gap = 0.5f * static_cast<float>(xx - yy);
  const float eigenvalue = mean - std::sqrt(half_gap * half_gap + static_cast<float>(xy) * static_cast<float>(xy));
  return std::max(eigenvalue, 0.0f) / (4.0f * samples);  // 4: g are halves of the differences above
}

/// FAST-9 tests on one image: the circle's offsets depend on its stride.
class FastTest {
 public:
  explicit FastTest(std::ptrdiff_t stride) {
    constexpr std::array<int, 16> dx{0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
    constexpr std::array<int, 16> dy{-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
    for (std::size_t i = 0; i < 16; ++i) circle_[i] = dy[i] * stride + dx[i];
  }

  bool operator()(const std::uint8_t* pixel, int threshold) const {
    const int high = *pixel + threshold, low = *pixel - threshold;
    // An arc of 9 holds one pixel of each opposite pair.
    const int north = pixel[circle_[0]], south = pixel[circle_[8]], east = pixel[circle_[4]], west = pixel[circle_[12]];
    const bool bright = (north > high || south > high) && (east > high || west > high);
    const bool dark = (north < low || south < low) && (east < low || west < low);
    if (!bright && !dark) return false;
    std::uint32_t brighter = 0, darker = 0;
    for (int i = 0; i < 16; ++i) {
      const int value = pixel[circle_[static_cast<std::size_t>(i)]];
      brighter |= static_cast<std::uint32_t>(value > high) << i;
      darker |= static_cast<std::uint32_t>(value < low) << i;
    }
    return has_arc(brighter) || has_arc(darker);
  }

 private:
  /// 9 contiguous bits of the 16 in a ring.
  static bool has_arc(std::uint32_t ring) {
    std::uint32_t runs = ring | ring << 16;
    runs &= runs >> 1;  // runs of 2, 4, 8
    runs &= runs >> 2;
    runs &= runs >> 4;
    return ((runs & (ring | ring << 16) >> 8) & 0xFFFFu) != 0;
  }

  std::array<std::ptrdiff_t, 16> circle_;
};

/// The cell's best corner among those farther than `distance_px` from all `near` features; score 0 when there is none.
template <std::size_t Near>
Corner best_corner(const ImageView<const std::uint8_t>& image, int x0, int y0, int x1, int y1,
                   const FixedVector<Vec<float, 2>, Near>& near, float distance_px, const CornerOptions& options) {
  Corner best{Vec<float, 2>::Zero(), 0.0f, 0};
  const auto consider = [&](int x, int y) {
    const float score = min_eigenvalue_score(image, x, y);
    if (!(score > best.score && score >= options.min_score)) return;
    const Vec<float, 2> uv(static_cast<float>(x), static_cast<float>(y));
    for (const Vec<float, 2>& other : near) {
      if ((other - uv).squaredNorm() < distance_px * distance_px) return;
    }
    best = {uv, score, 0};
  };
  const FastTest is_corner(image.stride);
  for (const int threshold : {options.fast_threshold, options.fast_threshold_low}) {
    for (int y = y0; y < y1; ++y) {
      for (int x = x0; x < x1; ++x) {
        if (is_corner(image.data + y * image.stride + x, threshold)) consider(x, y);
      }
    }
    if (best.score > 0.0f) return best;
  }
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) consider(x, y);
  }
  return best;
}

/// Appends to `out` new corners beside the `existing` features [px of level 0], best first; when `out` is too small the
/// weakest are left out.
template <std::size_t N>
void detect_corners(ImageView<const std::uint8_t> image, const Vec<float, 2>* existing, std::size_t n_existing,
                    const CornerOptions& options, FixedVector<Corner, N>& out) {
  PLUMBLINE_ASSERT(options.cell_px > 0 && options.border_px >= 4);
  if (image.empty()) return;
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
        const float dx = std::max({static_cast<float>(x0) - uv.x(), 0.0f, uv.x() - static_cast<float>(x1 - 1)});
        const float dy = std::max({static_cast<float>(y0) - uv.y(), 0.0f, uv.y() - static_cast<float>(y1 - 1)});
        if (dx < distance_px && dy < distance_px) occupied |= (dx < 0.5f && dy < 0.5f) || !near.push_back(uv);
      };
      for (std::size_t i = 0; i < n_existing && !occupied; ++i) note(existing[i]);
      for (std::size_t i = first; i < out.size() && !occupied; ++i) note(out[i].uv);
      if (occupied) continue;
      const Corner best = best_corner(image, x0, y0, x1, y1, near, distance_px, options);
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
