#pragma once
/// The pixels around a feature on the finest levels of the pyramid it was detected in: with them a landmark can be
/// aligned in any later image and the image it came from need not be kept.

#include <algorithm>
#include <array>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/pyramid.hpp"

namespace plumbline {

class ReferencePatch {
 public:
  static constexpr int max_levels = 3;
  static constexpr int size = 28;  ///< side of the copy on each level [px of the level]

  /// Copies the pixels around `uv` [px of level 0]. False, and the patch empty, when they leave the image on level 0;
  /// coarser levels are kept as far as they fit.
  template <class Pyr>
  bool capture(const Pyr& pyramid, const Vec<float, 2>& uv) {
    levels_ = 0;
    for (int l = 0; l < std::min(max_levels, Pyr::levels); ++l) {
      const ImageView<const std::uint8_t> image = pyramid.level(l);
      const Vec<float, 2> uv_level = to_level(uv, l);
      if (!image.contains(uv_level.x(), uv_level.y(), static_cast<float>(size / 2 - 1))) break;
      const int x0 = static_cast<int>(uv_level.x()) - (size / 2 - 1),
                y0 = static_cast<int>(uv_level.y()) - (size / 2 - 1);
      if (x0 + size > image.width || y0 + size > image.height) break;
      for (int y = 0; y < size; ++y) std::copy_n(image.row(y0 + y) + x0, size, pixels_[l].data() + y * size);
      centres_[l] = uv_level - Vec<float, 2>(static_cast<float>(x0), static_cast<float>(y0));
      ++levels_;
    }
    return levels_ > 0;
  }

  int levels() const { return levels_; }  ///< held; 0 when empty

  ImageView<const std::uint8_t> level(int l) const {
    PLUMBLINE_ASSERT(l >= 0 && l < levels_);
    return {pixels_[l].data(), size, size, size};
  }

  /// The feature in the pixels of `level(l)`.
  const Vec<float, 2>& centre(int l) const {
    PLUMBLINE_ASSERT(l >= 0 && l < levels_);
    return centres_[l];
  }

 private:
  std::array<std::array<std::uint8_t, size * size>, max_levels> pixels_{};
  std::array<Vec<float, 2>, max_levels> centres_;
  int levels_ = 0;
};

}  // namespace plumbline
