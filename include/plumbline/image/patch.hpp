#pragma once
/// Square patches of bilinear samples in contiguous floats, the raw material of patch alignment.
///
/// Samples 1 px apart share one sub-pixel fraction, so a patch is two passes of linear interpolation over whole rows,
/// which compilers vectorize.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

/// Size x Size samples, row by row. The center of a patch of even size lies between its four middle samples.
template <int Size>
using Patch = Vec<float, Size * Size>;

/// True when a patch of `size` samples 1 px apart around `center` needs no pixel beyond the edge; false for NaN too.
inline bool patch_inside(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& center, int size) {
  const float radius = 0.5f * static_cast<float>(size - 1);
  return center.x() >= radius && center.y() >= radius && center.x() + radius < static_cast<float>(image.width - 1) &&
         center.y() + radius < static_cast<float>(image.height - 1);
}

/// Copies size x size pixels from (x0, y0) on; pixels beyond the edge repeat the edge.
inline void copy_pixels(const ImageView<const std::uint8_t>& image, int x0, int y0, int size, std::uint8_t* out) {
  for (int y = 0; y < size; ++y) {
    const std::uint8_t* row = image.row(std::clamp(y0 + y, 0, image.height - 1));
    for (int x = 0; x < size; ++x) *out++ = row[std::clamp(x0 + x, 0, image.width - 1)];
  }
}

/// Samples 1 px apart around `center`, which must be in the image; beyond the edge they repeat the edge.
template <int Size>
void interpolate_patch(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& center, Patch<Size>& out) {
  PLUMBLINE_ASSERT(image.contains(center.x(), center.y(), 0.0f));
  const float radius = 0.5f * static_cast<float>(Size - 1);
  // A shift by Size makes the coordinates positive, so that conversion rounds down.
  const int x0 = static_cast<int>(center.x() - radius + Size) - Size;
  const int y0 = static_cast<int>(center.y() - radius + Size) - Size;
  const float ax = center.x() - radius - static_cast<float>(x0), ay = center.y() - radius - static_cast<float>(y0);
  std::uint8_t repeated[(Size + 1) * (Size + 1)];
  const std::uint8_t* row = image.data + y0 * image.stride + x0;
  std::ptrdiff_t stride = image.stride;
  if (x0 < 0 || y0 < 0 || x0 + Size >= image.width || y0 + Size >= image.height) {
    copy_pixels(image, x0, y0, Size + 1, repeated);
    row = repeated;
    stride = Size + 1;
  }
  const auto interpolate_row = [ax](const std::uint8_t* pixels, float* between) {
    float value[Size + 1];  // first of all out of the bytes, which could alias any store
    for (int x = 0; x <= Size; ++x) value[x] = pixels[x];
    for (int x = 0; x < Size; ++x) between[x] = value[x] + ax * (value[x + 1] - value[x]);
  };
  float rows[2][Size];
  interpolate_row(row, rows[0]);
  float* sample = out.data();
  for (int y = 0; y < Size; ++y, sample += Size) {
    row += stride;
    const float* upper = rows[y % 2];
    float* lower = rows[1 - y % 2];
    interpolate_row(row, lower);
    for (int x = 0; x < Size; ++x) sample[x] = upper[x] + ay * (lower[x] - upper[x]);
  }
}

/// Samples at center + A D_j, D_j the offsets of a patch 1 px apart. False when one of them is outside.
template <int Size>
bool interpolate_warped_patch(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& center,
                              const Mat<float, 2, 2>& A, Patch<Size>& out) {
  const float radius = 0.5f * static_cast<float>(Size - 1);
  constexpr float rounding_px = 0.01f;  // more than the sums below can be off
  const Vec<float, 2> extent(radius * (std::abs(A(0, 0)) + std::abs(A(0, 1))) + rounding_px,
                             radius * (std::abs(A(1, 0)) + std::abs(A(1, 1))) + rounding_px);
  const Vec<float, 2> low = center - extent, high = center + extent;
  if (!(low.x() >= 0.0f && low.y() >= 0.0f && high.x() < static_cast<float>(image.width - 1) &&
        high.y() < static_cast<float>(image.height - 1))) {
    return false;
  }
  // Where the samples are, their pixels, what lies between: compilers vectorize the first and the last.
  constexpr int n = Size * Size;
  int first[n], upper_left[n], upper_step[n], lower_left[n], lower_step[n];
  float ax[n], ay[n];
  const int stride = static_cast<int>(image.stride);
  for (int y = 0; y < Size; ++y) {
    const Vec<float, 2> start = center + A * Vec<float, 2>(-radius, static_cast<float>(y) - radius);
    for (int x = 0; x < Size; ++x) {
      const float u = start.x() + static_cast<float>(x) * A(0, 0), v = start.y() + static_cast<float>(x) * A(1, 0);
      const int x0 = static_cast<int>(u), y0 = static_cast<int>(v), k = y * Size + x;
      ax[k] = u - static_cast<float>(x0);
      ay[k] = v - static_cast<float>(y0);
      first[k] = y0 * stride + x0;
    }
  }
  for (int k = 0; k < n; ++k) {
    const std::uint8_t* const upper = image.data + first[k];
    const std::uint8_t* const lower = upper + image.stride;
    upper_left[k] = upper[0];
    upper_step[k] = upper[1] - upper[0];
    lower_left[k] = lower[0];
    lower_step[k] = lower[1] - lower[0];
  }
  for (int k = 0; k < n; ++k) {
    const float upper = static_cast<float>(upper_left[k]) + ax[k] * static_cast<float>(upper_step[k]);
    const float lower = static_cast<float>(lower_left[k]) + ax[k] * static_cast<float>(lower_step[k]);
    out[k] = upper + ay[k] * (lower - upper);
  }
  return true;
}

}  // namespace plumbline
