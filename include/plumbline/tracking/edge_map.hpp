#pragma once
/// Image gradients in 16-bit integers, and chains of pixels along their ridges.             docs/math/line.md
///
///   gx = [1 4 6 4 1]^T [-1 -2 0 2 1] * I,  gy its transpose                [intensity/px / 128]               (18)
///   strength = |gx| + |gy|, or 0 up to the threshold
/// An edge runs perpendicular to the gradient, the brighter side on a fixed hand: t = (gy, -gx). A chain walks from
/// pixel to pixel along t (and from its start along -t), to the strongest of the three next ones in the main direction
/// of t, until the strength is 0 or a pixel was taken before. Every pixel belongs to one chain at most: work is linear.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <type_traits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_mask.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/edge_queries.hpp"

namespace plumbline {

using EdgeChain = FixedVector<EdgePixel, 4096>;

template <std::size_t MaxPixels>
class EdgeMap : public EdgeQueries<EdgeMap<MaxPixels>> {
  using Queries = EdgeQueries<EdgeMap<MaxPixels>>;
  using Queries::height_;
  using Queries::width_;

 public:
  using Queries::border;
  using Queries::units;

  /// The threshold of the strength is a gradient [intensity/px]; pixels that the mask excludes have none. False when
  /// the image is empty, has more than MaxPixels pixels or is too small to have an inside.
  bool compute(const ImageView<const std::uint8_t>& image, float min_slope, const MaskView& mask = {}) {
    const int threshold = static_cast<int>(min_slope * units);
    width_ = height_ = 0;
    if (image.empty() || image.width <= 2 * border || image.height <= 2 * border || image.width > 32000 ||
        image.height > 32000 ||
        static_cast<std::size_t>(image.width) > MaxPixels / static_cast<std::size_t>(image.height))
      return false;
    width_ = image.width;
    height_ = image.height;
    for (int y = 0; y < height_; ++y) {
      if (y < border || y >= height_ - border) {
        clear(index(0, y), width_);
        continue;
      }
      clear(index(0, y), border);
      const int end = width_ - border;
      if (end - border < block) {
        compute_block(image, border, y, end - border, threshold);
      } else {  // whole blocks, the last one again with some of the one before
        for (int x = border; x < end; x += block) compute_block(image, std::min(x, end - block), y, whole, threshold);
      }
      clear(index(width_ - border, y), border);
      for (int x = border; x < end && !mask.empty(); ++x) {
        if (mask.excludes(x, y)) clear(index(x, y), 1);
      }
    }
    return true;
  }

  int index(int x, int y) const { return y * width_ + x; }
  EdgeGradient gradient(int x, int y) const { return gradients_[static_cast<std::size_t>(index(x, y))]; }
  EdgeGradient gradient_inside(int x, int y) const { return gradient(x, y); }
  int gx(int i) const { return gradients_[static_cast<std::size_t>(i)].x; }
  int gy(int i) const { return gradients_[static_cast<std::size_t>(i)].y; }
  /// 0: below the threshold; negative: taken by a chain.
  int strength(int i) const { return strength_[static_cast<std::size_t>(i)]; }
  bool is_steep(int i) const { return gradients_[static_cast<std::size_t>(i)].is_steep(); }

  /// Calls `take(chain)` for each chain, started at local maxima of the strength in every `spacing`-th row (steep
  /// edges) and column (flat ones). A chain that is full ends; what is left of its edge is another chain.
  void for_each_chain(int spacing, EdgeChain& chain, auto&& take) {
    for (int y = border; y < height_ - border; ++y) {
      const int step = y % spacing == 0 ? 1 : spacing;
      for (int x = border; x < width_ - border; x += step) {
        const int i = index(x, y), s = strength(i);
        if (s <= 0) continue;
        const bool steep = is_steep(i);
        if (steep ? step != 1 : x % spacing != 0) continue;
        const int across = steep ? 1 : width_;
        if (s < std::abs(strength(i - across)) || s <= std::abs(strength(i + across))) continue;
        chain.clear();
        walk(i, -1, chain);
        std::reverse(chain.begin(), chain.end());
        if (!chain.empty()) chain.pop_back();  // the start, which the other way begins with
        strength_[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(s);
        walk(i, 1, chain);
        take(chain);
      }
    }
  }

 private:
  static constexpr int block = 128;
  static constexpr std::integral_constant<int, block> whole{};

  void clear(int first, int n) {
    std::fill_n(gradients_.data() + first, n, EdgeGradient{0, 0});
    std::fill_n(strength_.data() + first, n, std::int16_t(0));
  }

  /// (18) for `n` pixels of row y from x on: an integer, or `whole`, with which all loops are whole vectors.
  void compute_block(const ImageView<const std::uint8_t>& image, int x, int y, auto n, int threshold) {
    std::int16_t smooth[block + 4], slope[block + 4];  // of the columns
    const std::ptrdiff_t stride = image.stride;
    const std::uint8_t* const center = image.data + y * stride + x - 2;
    const auto column = [&](int k) {
      const std::uint8_t* const p = center + k;
      const int a = p[-2 * stride], b = p[-stride], c = p[0], d = p[stride], e = p[2 * stride];
      smooth[k] = static_cast<std::int16_t>(a + e + 4 * (b + d) + 6 * c);
      slope[k] = static_cast<std::int16_t>(e - a + 2 * (d - b));
    };
    for (int k = 0; k < n; ++k) column(k);
    for (int k = n; k < n + 4; ++k) column(k);
    EdgeGradient gradient[block];
    std::int16_t strength[block];
    for (int k = 0; k < n; ++k) {
      const std::int16_t u = static_cast<std::int16_t>(smooth[k + 4] - smooth[k] + 2 * (smooth[k + 3] - smooth[k + 1]));
      const std::int16_t v =
          static_cast<std::int16_t>(slope[k] + slope[k + 4] + 4 * (slope[k + 1] + slope[k + 3]) + 6 * slope[k + 2]);
      const std::int16_t s = static_cast<std::int16_t>(std::abs(u) + std::abs(v));
      gradient[k] = {u, v};
      strength[k] = s > threshold ? s : std::int16_t(0);
    }
    std::copy_n(gradient, int(n), gradients_.data() + index(x, y));
    std::copy_n(strength, int(n), strength_.data() + index(x, y));
  }

  /// Along t (sign 1) or against it (-1), from pixel i on.
  void walk(int i, int sign, EdgeChain& chain) {
    int y = i / width_, x = i - y * width_;
    while (strength(i) > 0 && chain.push_back({static_cast<std::int16_t>(x), static_cast<std::int16_t>(y)})) {
      strength_[static_cast<std::size_t>(i)] = static_cast<std::int16_t>(-strength(i));
      const bool steep = is_steep(i);
      const int forth = steep ? (gx(i) > 0 ? -sign : sign) : (gy(i) > 0 ? sign : -sign);
      const int next = i + (steep ? forth * width_ : forth), across = steep ? 1 : width_;
      const int before = std::abs(strength(next - across)), straight = std::abs(strength(next)),
                after = std::abs(strength(next + across));
      // no branches: which of the three is unpredictable
      const int side = int(after > straight && after > before) - int(before > straight && before >= after);
      i = next + side * across;
      x += steep ? side : forth;
      y += steep ? forth : side;
    }
  }

  std::array<EdgeGradient, MaxPixels> gradients_;
  std::array<std::int16_t, MaxPixels> strength_;
};

}  // namespace plumbline
