#pragma once
/// Image pyramid by 2x2 means, all levels stored inside the object.                        docs/math/tracking.md
///
///   I_l(x, y) = ( I_{l-1}(2x, 2y) + I_{l-1}(2x+1, 2y) + I_{l-1}(2x, 2y+1) + I_{l-1}(2x+1, 2y+1) + 2 ) / 4      (1)
///   u_l = (u_0 + 0.5) / 2^l - 0.5,   u_0 = (u_l + 0.5) 2^l - 0.5                                               (2)
/// An odd last row or column has no pixel on the next level; (2) stays exact.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_mask.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

/// Pixel of level 0 seen on `level`.                                                                             (2)
inline Vec<float, 2> to_level(const Vec<float, 2>& uv, int level) {
  const float scale = 1.0f / static_cast<float>(1 << level);
  return {(uv.x() + 0.5f) * scale - 0.5f, (uv.y() + 0.5f) * scale - 0.5f};
}

/// Pixel of `level` seen on level 0.                                                                             (2)
inline Vec<float, 2> from_level(const Vec<float, 2>& uv_level, int level) {
  const float scale = static_cast<float>(1 << level);
  return {(uv_level.x() + 0.5f) * scale - 0.5f, (uv_level.y() + 0.5f) * scale - 0.5f};
}

template <int Levels, std::size_t MaxPixels>
class Pyramid {
  static_assert(Levels >= 1 && Levels <= 10, "plumbline: a pyramid has 1 to 10 levels");

 public:
  static constexpr int levels = Levels;
  static constexpr int min_top_px = 16;  ///< smallest side of the top level [px]

  /// Copies level 0 and builds the others. False, and the pyramid empty, when the image is empty, has more than
  /// MaxPixels pixels or is smaller than `min_top_px` on the top level.
  bool build(ImageView<const std::uint8_t> level0) {
    width_ = height_ = 0;
    if (level0.empty() || (level0.width >> (Levels - 1)) < min_top_px || (level0.height >> (Levels - 1)) < min_top_px ||
        static_cast<std::size_t>(level0.width) > MaxPixels / static_cast<std::size_t>(level0.height)) {
      return false;
    }
    width_ = level0.width;
    height_ = level0.height;
    std::size_t offset = 0;
    for (int l = 0; l < Levels; ++l) {
      offsets_[l] = offset;
      const std::size_t pixels = static_cast<std::size_t>(width_ >> l) * static_cast<std::size_t>(height_ >> l);
      offset += (pixels + alignment - 1) / alignment * alignment;
    }
    for (int y = 0; y < height_; ++y) std::copy_n(level0.row(y), width_, pixels_.data() + y * width_);
    for (int l = 1; l < Levels; ++l) halve(level(l - 1), pixels_.data() + offsets_[l]);
    return true;
  }

  ImageView<const std::uint8_t> level(int l) const {
    PLUMBLINE_ASSERT(l >= 0 && l < Levels);
    if (empty()) return {};
    return {pixels_.data() + offsets_[l], width_ >> l, height_ >> l, width_ >> l};
  }

  bool empty() const { return width_ == 0; }

  /// The pixels of level 0 that show no static scene; they must outlive it.
  void set_mask(const MaskView& mask) { mask_ = mask; }
  const MaskView& mask() const { return mask_; }

 private:
  static constexpr std::size_t alignment = 32;

  static constexpr std::size_t capacity() {
    std::size_t sum = 0;
    for (int l = 0; l < Levels; ++l) sum += (MaxPixels >> (2 * l)) + alignment;
    return sum;
  }

  /// (1)
  static void halve(const ImageView<const std::uint8_t>& fine, std::uint8_t* coarse) {
    const int width = fine.width / 2, height = fine.height / 2;
    for (int y = 0; y < height; ++y) {
      const std::uint8_t* upper = fine.row(2 * y);
      const std::uint8_t* lower = upper + fine.stride;
      std::uint8_t* out = coarse + static_cast<std::ptrdiff_t>(y) * width;
      for (int x = 0; x < width; ++x) {
        out[x] =
            static_cast<std::uint8_t>((upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1] + 2) >> 2);
      }
    }
  }

  alignas(alignment) std::array<std::uint8_t, capacity()> pixels_{};
  std::array<std::size_t, Levels> offsets_{};
  int width_ = 0, height_ = 0;  ///< of level 0 [px]
  MaskView mask_;
};

}  // namespace plumbline
