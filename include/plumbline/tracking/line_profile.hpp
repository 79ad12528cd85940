#pragma once
/// What an edge looks like across: intensities at fixed distances, averaged along the segment.  docs/math/line.md
///
///   similarity = sum a b / sqrt(sum a^2 sum b^2)  of the profiles without their means                        (21)
/// Gain and bias do not matter.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// Mean intensities 4 px on the dark side to 4 px on the bright side.
struct LineProfile {
  static constexpr int radius = 4;  ///< [px]
  Vec<float, 2 * radius + 1> mean = zeros<float, 2 * radius + 1>();

  /// (21), in [-1, 1]; 0 when one of them has no contrast.
  float similarity(const LineProfile& other) const {
    Vec<float, 2 * radius + 1> a, b;
    const float mean_a = mean.mean(), mean_b = other.mean.mean();
    for (int k = 0; k < 2 * radius + 1; ++k) {
      a[k] = mean[k] - mean_a;
      b[k] = other.mean[k] - mean_b;
    }
    const float scale = std::sqrt(a.squaredNorm() * b.squaredNorm());
    return scale > 0 ? a.dot(b) / scale : 0.0f;
  }
};

/// Averages over at most 24 places along the segment; those too near to the image's edge are left out.
inline LineProfile profile_of(const ImageView<const std::uint8_t>& image, const LineSegment& segment) {
  const Vec<float, 2> normal = segment.normal(), extent = segment.end - segment.start;
  const int places = std::max(4, static_cast<int>(std::min(24.0f, segment.length() / 4)));  // 24 for NaN
  LineProfile out;
  int n = 0;
  for (int k = 0; k < places; ++k) {
    const Vec<float, 2> at = segment.start + (static_cast<float>(k) + 0.5f) / static_cast<float>(places) * extent;
    if (!image.contains(at.x(), at.y(), LineProfile::radius + 1.0f)) continue;
    for (int j = -LineProfile::radius; j <= LineProfile::radius; ++j) {
      const Vec<float, 2> uv = at + static_cast<float>(j) * normal;
      out.mean[j + LineProfile::radius] += interpolate(image, uv.x(), uv.y());
    }
    ++n;
  }
  if (n > 0) out.mean /= static_cast<float>(n);
  return out;
}

}  // namespace plumbline
