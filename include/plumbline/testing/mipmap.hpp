#pragma once
/// An 8-bit texture with its mip chain, baked from a function of (u, v) [m] and sampled anti-aliased: trilinear, with
/// up to four taps along the long axis of the pixel's footprint.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace plumbline::testing {

class Mipmap {
 public:
  /// Bakes radiance(u, v) in 0..255 over width x height [m] with square texels of about `texel` [m].
  template <class F>
  Mipmap(F&& radiance, float width, float height, float texel) {
    const auto count = [&](float length) { return std::max(2, static_cast<int>(std::lround(length / texel))); };
    levels_.push_back({0, count(width), count(height)});
    scale_u_ = static_cast<float>(levels_[0].width) / width;
    scale_v_ = static_cast<float>(levels_[0].height) / height;
    for (int y = 0; y < levels_[0].height; ++y) {
      for (int x = 0; x < levels_[0].width; ++x) {
        texels_.push_back(
            to_byte(radiance((static_cast<float>(x) + 0.5f) / scale_u_, (static_cast<float>(y) + 0.5f) / scale_v_)));
      }
    }
    band_limit();
    while (levels_.back().width > 1 || levels_.back().height > 1) halve();
  }

  /// Radiance at (u, v) [m]. The columns of the footprint, d(u, v)/d(pixel) [m/px], are (ux, vx) and (uy, vy).
  float sample(float u, float v, float ux, float vx, float uy, float vy) const {
    u *= scale_u_, ux *= scale_u_, uy *= scale_u_;
    v *= scale_v_, vx *= scale_v_, vy *= scale_v_;
    float major2 = ux * ux + vx * vx, axis_u = ux, axis_v = vx;
    if (const float other2 = uy * uy + vy * vy; other2 > major2) major2 = other2, axis_u = uy, axis_v = vy;
    const float major = std::sqrt(major2), minor = std::abs(ux * vy - uy * vx) / std::max(major, 1e-12f);
    const int taps =
        minor * max_taps > major ? std::clamp(static_cast<int>(major / minor + 0.5f), 1, max_taps) : max_taps;
    const float lod = std::log2(std::max({minor, major / static_cast<float>(taps), 1e-6f}));
    if (taps == 1) return trilinear(u, v, lod);
    float sum = 0;
    for (int i = 0; i < taps; ++i) {
      const float offset = (static_cast<float>(i) + 0.5f) / static_cast<float>(taps) - 0.5f;
      sum += trilinear(u + offset * axis_u, v + offset * axis_v, lod);
    }
    return sum / static_cast<float>(taps);
  }

 private:
  static constexpr int max_taps = 4;
  struct Level {
    std::size_t begin;
    int width, height;
  };

  static std::uint8_t to_byte(float x) { return static_cast<std::uint8_t>(std::clamp(x, 0.0f, 255.0f) + 0.5f); }

  float trilinear(float u, float v, float lod) const {
    if (lod <= 0) return bilinear(0, u, v);
    const int last = static_cast<int>(levels_.size()) - 1, fine = std::min(static_cast<int>(lod), last);
    if (fine == last) return bilinear(last, u, v);
    const float a = lod - static_cast<float>(fine);
    return (1 - a) * bilinear(fine, u, v) + a * bilinear(fine + 1, u, v);
  }

  float bilinear(int index, float u, float v) const {
    const Level& level = levels_[static_cast<std::size_t>(index)];
    const float shrink = 1 / static_cast<float>(1 << index);
    const float x = std::clamp(u * shrink - 0.5f, 0.0f, static_cast<float>(level.width - 1));
    const float y = std::clamp(v * shrink - 0.5f, 0.0f, static_cast<float>(level.height - 1));
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const int dx = x0 + 1 < level.width ? 1 : 0, dy = y0 + 1 < level.height ? level.width : 0;
    const std::uint8_t* p = texels_.data() + level.begin + y0 * level.width + x0;
    const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
    const float top = static_cast<float>(p[0]) * (1 - a) + static_cast<float>(p[dx]) * a;
    const float bottom = static_cast<float>(p[dy]) * (1 - a) + static_cast<float>(p[dx + dy]) * a;
    return top * (1 - b) + bottom * b;
  }

  /// 3x3 binomial filter of level 0, so that drawn edges span a texel and more.
  void band_limit() {
    const int width = levels_[0].width, height = levels_[0].height;
    const std::vector<std::uint8_t> in = texels_;
    for (int y = 0; y < height; ++y) {
      const std::uint8_t* mid = in.data() + y * width;
      const std::uint8_t *up = y > 0 ? mid - width : mid, *down = y + 1 < height ? mid + width : mid;
      const auto column = [&](int x) { return up[x] + 2 * mid[x] + down[x]; };
      for (int x = 0; x < width; ++x) {
        const int sum = column(std::max(x - 1, 0)) + 2 * column(x) + column(std::min(x + 1, width - 1));
        texels_[static_cast<std::size_t>(y * width + x)] = static_cast<std::uint8_t>((sum + 8) / 16);
      }
    }
  }

  void halve() {
    const Level in = levels_.back();
    const Level out{texels_.size(), (in.width + 1) / 2, (in.height + 1) / 2};
    texels_.resize(out.begin + static_cast<std::size_t>(out.width * out.height));
    for (int y = 0; y < out.height; ++y) {
      for (int x = 0; x < out.width; ++x) {
        const int x1 = std::min(2 * x + 1, in.width - 1), y1 = std::min(2 * y + 1, in.height - 1);
        const auto at = [&](int i, int j) { return texels_[in.begin + static_cast<std::size_t>(j * in.width + i)]; };
        texels_[out.begin + static_cast<std::size_t>(y * out.width + x)] =
            static_cast<std::uint8_t>((at(2 * x, 2 * y) + at(x1, 2 * y) + at(2 * x, y1) + at(x1, y1) + 2) / 4);
      }
    }
    levels_.push_back(out);
  }

  std::vector<Level> levels_;
  std::vector<std::uint8_t> texels_;
  float scale_u_ = 0, scale_v_ = 0;  ///< [texels/m]
};

}  // namespace plumbline::testing
