#pragma once
/// The pixels around a feature on the finest levels of the pyramid it was detected in: with them a landmark can be
/// aligned in any later image and the image it came from need not be kept.

#include <algorithm>
#include <array>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/patch.hpp"
#include "plumbline/image/pyramid.hpp"

namespace plumbline {

/// Size: side of the copy on each level [px of the level].
template <int Size, int MaxLevels>
class PatchCopy {
 public:
  static constexpr int max_levels = MaxLevels;
  static constexpr int size = Size;

  /// Copies the pixels around `uv` [px of level 0]. False, and the patch empty, when they leave the image on level 0;
  /// on coarser levels pixels beyond the edge repeat the edge.
  template <class Pyr>
  bool capture(const Pyr& pyramid, const Vec<float, 2>& uv) {
    levels_ = 0;
    if (!patch_inside(pyramid.level(0), uv, size - 1)) return false;
    for (int l = 0; l < std::min(max_levels, Pyr::levels); ++l) {
      const Vec<float, 2> uv_level = to_level(uv, l);
      // positive before the shift, so that conversion rounds down
      const int x0 = static_cast<int>(uv_level.x() + 1.0f) - size / 2,
                y0 = static_cast<int>(uv_level.y() + 1.0f) - size / 2;
      copy_pixels(pyramid.level(l), x0, y0, size, pixels_[l].data());
      centers_[l] = uv_level - Vec<float, 2>(static_cast<float>(x0), static_cast<float>(y0));
      ++levels_;
    }
    return true;
  }

  /// Copies the middle of a larger copy.
  template <int LargerSize, int Levels>
  void crop(const PatchCopy<LargerSize, Levels>& larger) {
    static_assert(LargerSize >= size, "plumbline: a crop is not larger than what it is taken from");
    levels_ = std::min(max_levels, larger.levels());
    for (int l = 0; l < levels_; ++l) {
      const auto begin = [&](float center) {
        return std::clamp(static_cast<int>(center + 1.0f) - size / 2, 0, LargerSize - size);
      };
      const int x0 = begin(larger.center(l).x()), y0 = begin(larger.center(l).y());
      copy_pixels(larger.level(l), x0, y0, size, pixels_[l].data());
      centers_[l] = larger.center(l) - Vec<float, 2>(static_cast<float>(x0), static_cast<float>(y0));
    }
  }

  int levels() const { return levels_; }  ///< held; 0 when empty

  ImageView<const std::uint8_t> level(int l) const {
    PLUMBLINE_ASSERT(l >= 0 && l < levels_);
    return {pixels_[l].data(), size, size, size};
  }

  /// The feature in the pixels of `level(l)`.
  const Vec<float, 2>& center(int l) const {
    PLUMBLINE_ASSERT(l >= 0 && l < levels_);
    return centers_[l];
  }

 private:
  std::array<std::array<std::uint8_t, size * size>, max_levels> pixels_{};
  std::array<Vec<float, 2>, max_levels> centers_ = {};
  int levels_ = 0;
};

/// Of a landmark of the window.
using ReferencePatch = PatchCopy<28, 3>;

}  // namespace plumbline
