#pragma once
/// Mask of an image: pixels that do not show the static scene (a vehicle's bonnet, a drone's legs, a gimbal), one bit a
/// pixel of pyramid level 0.
///
/// A feature is measured by a patch around it, so a pixel is excluded if any pixel within `margin_px` of it, in x and
/// in y, is zero in the given image: features keep the same distance to the mask as to the edge of the image.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

/// The excluded pixels of an image; does not own them. The default excludes none.
class MaskView {
 public:
  MaskView() = default;
  MaskView(const std::uint8_t* bits, int width, int height) : bits_(bits), width_(width), height_(height) {}

  bool empty() const { return bits_ == nullptr; }
  /// Whether the pixel (x, y) is excluded; it is inside the image.
  bool excludes(int x, int y) const {
    if (empty()) return false;
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    return (bits_[i / 8] >> (i % 8) & 1) != 0;
  }
  /// The same of the nearest pixel; false outside the image and for NaN.
  bool excludes(const Vec<float, 2>& uv) const {
    if (empty()) return false;
    const float u = uv.x() + 0.5f, v = uv.y() + 0.5f;
    const bool is_inside = u >= 0 && v >= 0 && u < static_cast<float>(width_) && v < static_cast<float>(height_);
    return is_inside && excludes(static_cast<int>(u), static_cast<int>(v));
  }

 private:
  const std::uint8_t* bits_ = nullptr;
  int width_ = 0, height_ = 0;
};

template <std::size_t MaxPixels>
class ImageMask {
 public:
  static constexpr int margin_px = 8;  ///< geometry: half an alignment patch and the interpolation's neighbor

  /// Excludes the zero pixels of `image` and those near them; none if it is empty. False, and none excluded, when it
  /// has more than MaxPixels pixels.
  bool set(const ImageView<const std::uint8_t>& image) {
    width_ = height_ = 0;
    if (image.empty()) return true;
    if (static_cast<std::size_t>(image.width) > MaxPixels / static_cast<std::size_t>(image.height)) return false;
    bits_.fill(0);
    for (int y = 0; y < image.height; ++y) {
      const int top = std::max(0, y - margin_px), bottom = std::min(image.height - 1, y + margin_px);
      int next = 0;  // pixels before it are set where they must be
      for (int x = 0; x < image.width; ++x) {
        bool is_zero = false;
        for (int v = top; v <= bottom && !is_zero; ++v) is_zero = image.row(v)[x] == 0;
        if (!is_zero) continue;
        const int end = std::min(image.width, x + margin_px + 1);
        for (next = std::max(next, x - margin_px); next < end; ++next) exclude(image.width, next, y);
      }
    }
    width_ = image.width;
    height_ = image.height;
    return true;
  }

  MaskView view() const { return width_ == 0 ? MaskView() : MaskView(bits_.data(), width_, height_); }

 private:
  void exclude(int width, int x, int y) {
    const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    bits_[i / 8] = static_cast<std::uint8_t>(bits_[i / 8] | 1u << (i % 8));
  }

  std::array<std::uint8_t, (MaxPixels + 7) / 8> bits_;
  int width_ = 0, height_ = 0;
};

}  // namespace plumbline
