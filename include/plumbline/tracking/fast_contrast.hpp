#pragma once
/// FAST-9 of many pixels at once.                                                           docs/math/tracking.md
///
/// 9 contiguous pixels of the 16 on a circle of radius 3 are all brighter than I + t or all darker than I - t. The
/// contrast is the least t that a pixel does not pass:
///   max(max_arcs min_arc I_i - I, I - min_arcs max_arc I_i)
/// Two arcs that are neighbors share 8 pixels; 8 such pairs are all arcs. Bytes, no branches.

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

class FastContrast {
 public:
  /// The circle's offsets depend on the image's stride.
  explicit FastContrast(std::ptrdiff_t stride) {
    constexpr std::array<int, 16> dx{0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3, -3, -3, -2, -1};
    constexpr std::array<int, 16> dy{-3, -3, -2, -1, 0, 1, 2, 3, 3, 3, 2, 1, 0, -1, -2, -3};
    for (std::size_t i = 0; i < 16; ++i) circle_[i] = dy[i] * stride + dx[i];
  }

  /// None of `Size` pixels from `row` on has a larger contrast: an arc of 9 holds a pixel of each opposite pair, and
  /// four pairs are looked at.
  template <int Size>
  std::uint8_t bound_of_row(const std::uint8_t* row) const {
    return bound_of_row<Size>(row, std::make_index_sequence<4>{});
  }
  /// Of `Size` pixels from `row` on, none nearer than 3 px to the image's edge.
  template <int Size>
  std::array<std::uint8_t, Size> of_row(const std::uint8_t* row) const {
    return of_row<Size>(row, std::make_index_sequence<16>{});
  }

 private:
  using Ring = std::array<std::uint8_t, 16>;
  struct Less {
    std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return a < b ? a : b; }
  };
  struct Greater {
    std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return a > b ? a : b; }
  };

  template <int Size, std::size_t... k>
  std::uint8_t bound_of_row(const std::uint8_t* row, std::index_sequence<k...>) const {
    constexpr Less less;
    constexpr Greater greater;
    const std::array<std::ptrdiff_t, 16> circle = circle_;
    std::uint8_t bound = 0;
    for (std::size_t x = 0; x < Size; ++x) {
      const std::uint8_t* const pixel = row + x;
      std::uint8_t brighter = 255, darker = 0;
      ((brighter = less(brighter, greater(pixel[circle[2 * k]], pixel[circle[2 * k + 8]]))), ...);
      ((darker = greater(darker, less(pixel[circle[2 * k]], pixel[circle[2 * k + 8]]))), ...);
      bound = greater(bound, excess(brighter, darker, *pixel));
    }
    return bound;
  }
  template <int Size, std::size_t... i>
  std::array<std::uint8_t, Size> of_row(const std::uint8_t* row, std::index_sequence<i...>) const {
    constexpr Less less;
    constexpr Greater greater;
    const std::array<std::ptrdiff_t, 16> circle = circle_;  // a local copy that no store of bytes can alias
    std::array<std::uint8_t, Size> out;
    for (std::size_t x = 0; x < Size; ++x) {
      const std::uint8_t* const pixel = row + x;
      const Ring ring{pixel[circle[i]]...};
      const std::uint8_t brighter = best_arc(ring, less, greater, std::make_index_sequence<8>{});
      const std::uint8_t darker = best_arc(ring, greater, less, std::make_index_sequence<8>{});
      out[x] = excess(brighter, darker, *pixel);
    }
    return out;
  }

  /// By how much the brighter ones are above `center`, or the darker ones below.
  EIGEN_ALWAYS_INLINE static std::uint8_t excess(std::uint8_t brighter, std::uint8_t darker, std::uint8_t center) {
    const std::uint8_t above = static_cast<std::uint8_t>(Greater{}(brighter, center) - center);
    return Greater{}(above, static_cast<std::uint8_t>(center - Less{}(darker, center)));
  }
  /// The best of all arcs by the worst of their pixels. A fold and no loops: what surrounds it becomes vectors.
  template <class Worse, class Better, std::size_t... k>
  EIGEN_ALWAYS_INLINE static std::uint8_t best_arc(const Ring& ring, const Worse& worse, const Better& better,
                                                   std::index_sequence<k...>) {
    using Octet = std::array<std::uint8_t, 8>;
    const Octet two{worse(ring[2 * k + 1], ring[(2 * k + 2) % 16])...};
    const Octet four{worse(two[k], two[(k + 1) % 8])...};
    const Octet eight{worse(four[k], four[(k + 2) % 8])...};
    const Octet nine{worse(eight[k], better(ring[2 * k], ring[(2 * k + 9) % 16]))...};
    std::uint8_t best = nine[0];
    ((best = better(best, nine[k])), ...);
    return best;
  }

  std::array<std::ptrdiff_t, 16> circle_;
};

}  // namespace plumbline
