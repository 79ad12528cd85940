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
#include <cmath>
#include <cstddef>
#include <cstdint>

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

/// The scores (11) of a square tile of pixels, by sums over columns that slide down and sums over rows: the work does
/// not depend on the texture, and all loops are of constant length over floats (exact: the sums are below 2^24).
class ScoreTile {
 public:
  static constexpr int size = 32;   ///< [px]
  static constexpr int margin = 4;  ///< pixels read around the tile
  using Row = Eigen::Array<float, size, 1>;

  /// Scores of the pixels from (x0, y0) on; the tile and its margin must be inside the image.
  void compute(const ImageView<const std::uint8_t>& image, int x0, int y0) {
    PLUMBLINE_ASSERT(x0 >= margin && y0 >= margin && x0 + size + margin <= image.width);
    PLUMBLINE_ASSERT(y0 + size + margin <= image.height);
    Sums column[window];  // products of the last 7 rows
    Sums sum;
    set_zero(sum);
    for (Sums& products : column) set_zero(products);
    for (int y = 0; y < size + window - 1; ++y) {
      Sums& products = column[y % window];
      sum -= products;
      gradient_products(image.data + (y0 + y - radius) * image.stride + x0 - radius, image.stride, products);
      sum += products;
      if (y >= window - 1) rows_[static_cast<std::size_t>(y - window + 1)] = score(sum);
    }
  }

  const Row& row(int y) const { return rows_[static_cast<std::size_t>(y)]; }

 private:
  static constexpr int radius = 3, window = 2 * radius + 1, columns = size + window - 1;
  using Sums = Eigen::Array<float, columns, 3>;  // xx, xy, yy of each column

  static void gradient_products(const std::uint8_t* row, std::ptrdiff_t stride, Sums& products) {
    float* xx = products.data();
    float* xy = xx + columns;
    float* yy = xy + columns;
    for (int x = 0; x < columns; ++x) {
      const float gx = static_cast<float>(row[x + 1] - row[x - 1]);
      const float gy = static_cast<float>(row[x + stride] - row[x - stride]);
      xx[x] = gx * gx;
      xy[x] = gx * gy;
      yy[x] = gy * gy;
    }
  }

  /// Smallest eigenvalues from the sums over 7 columns.
  static Row score(const Sums& sum) {
    std::array<Row, 3> seven;
    for (int c = 0; c < 3; ++c) {
      const float* one = sum.data() + c * columns;
      std::array<float, columns - 1> two;
      for (std::size_t x = 0; x < two.size(); ++x) two[x] = one[x] + one[x + 1];
      float* out = seven[static_cast<std::size_t>(c)].data();
      for (std::size_t x = 0; x < size; ++x) out[x] = two[x] + two[x + 2] + two[x + 4] + one[x + 6];
    }
    const Row mean = 0.5f * (seven[0] + seven[2]), half_gap = 0.5f * (seven[0] - seven[2]);
    const Row eigenvalue = mean - (half_gap.square() + seven[1].square()).sqrt();
    return eigenvalue * (1.0f / (4 * window * window));  // 4: g are halves of the differences above
  }

  std::array<Row, size> rows_;
};

/// FAST-9 tests on one image: the circle's offsets depend on its stride.
class FastTest {
 public:
  explicit FastTest(std::ptrdiff_t stride) {
    constexpr std::array<int, 16> dx{0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
    constexpr std::array<int, 16> dy{-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
    for (std::size_t i = 0; i < 16; ++i) circle_[i] = dy[i] * stride + dx[i];
  }

  /// Upper bounds of the thresholds that `Size` pixels from `row` on can pass: an arc of 9 holds a pixel of each
  /// opposite pair, and four pairs are looked at.
  template <int Size>
  std::array<std::uint8_t, Size> bounds(const std::uint8_t* row) const {
    const std::array<std::ptrdiff_t, 16> circle = circle_;  // a local copy that no store of bytes can alias
    std::array<std::uint8_t, Size> out;
    const auto lesser = [](std::uint8_t a, std::uint8_t b) { return a < b ? a : b; };
    const auto greater = [](std::uint8_t a, std::uint8_t b) { return a > b ? a : b; };
    for (int x = 0; x < Size; ++x) {
      const std::uint8_t* pixel = row + x;
      std::uint8_t bright = 255, dark = 0;
      for (std::size_t i = 0; i < 8; i += 2) {
        const std::uint8_t one = pixel[circle[i]], opposite = pixel[circle[i + 8]];
        bright = lesser(bright, greater(one, opposite));
        dark = greater(dark, lesser(one, opposite));
      }
      const std::uint8_t centre = *pixel;
      out[static_cast<std::size_t>(x)] = greater(static_cast<std::uint8_t>(greater(bright, centre) - centre),
                                                 static_cast<std::uint8_t>(centre - lesser(dark, centre)));
    }
    return out;
  }

  bool operator()(const std::uint8_t* pixel, int threshold) const {
    const int high = *pixel + threshold, low = *pixel - threshold;
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

/// The best corner of the cell [x0, x1) x [y0, y1) among those at least `distance_px` from all `near` features: one of
/// FAST with the high threshold, else with the low one, else any pixel. Score 0 when there is none.
template <std::size_t Near>
Corner best_corner(const ImageView<const std::uint8_t>& image, int x0, int y0, int x1, int y1,
                   const FixedVector<Vec<float, 2>, Near>& near, float distance_px, const CornerOptions& options) {
  const FastTest is_fast(image.stride);
  const auto is_free = [&](const Vec<float, 2>& uv) {
    return std::none_of(near.begin(), near.end(), [&](const Vec<float, 2>& other) {
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
      scores.compute(image, left, top);
      for (int y = tile_y; y < std::min(tile_y + ScoreTile::size, y1); ++y) {
        const ScoreTile::Row& row = scores.row(y - top);
        const float row_best = row.maxCoeff();
        if (!(row_best >= options.min_score) || (best_grade == 3 && !(row_best > best.score))) continue;
        const std::uint8_t* pixels = image.data + y * image.stride + left;
        const std::array<std::uint8_t, ScoreTile::size> bounds = is_fast.bounds<ScoreTile::size>(pixels);
        for (int x = tile_x - left; x < std::min(tile_x + ScoreTile::size, x1) - left; ++x) {
          const int bound = bounds[static_cast<std::size_t>(x)];
          const int hoped = 1 + (bound > options.fast_threshold_low) + (bound > options.fast_threshold);
          const bool stronger = row[x] > best.score;
          if (!(row[x] >= options.min_score) || hoped < best_grade + !stronger) continue;
          int grade = 1;
          if (hoped >= 3 && is_fast(pixels + x, options.fast_threshold)) {
            grade = 3;
          } else if (hoped >= 2 && best_grade + !stronger <= 2 && is_fast(pixels + x, options.fast_threshold_low)) {
            grade = 2;
          }
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
/// weakest are left out. Images smaller than 40 px give none.
template <std::size_t N>
void detect_corners(ImageView<const std::uint8_t> image, const Vec<float, 2>* existing, std::size_t n_existing,
                    const CornerOptions& options, FixedVector<Corner, N>& out) {
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
