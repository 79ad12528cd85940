#pragma once
/// Corners as docs/math/tracking.md defines them, pixel by pixel.

#include <cmath>
#include <cstdint>

#include "plumbline/image/image_view.hpp"

namespace plumbline::testing {

using GrayView = ImageView<const std::uint8_t>;

/// FAST-9 as it is defined: some 9 in a row are all brighter or all darker.
inline bool is_fast_corner(const GrayView& image, int x, int y, int threshold) {
  constexpr int circle[16][2] = {{0, -3}, {1, -3}, {2, -2}, {3, -1}, {3, 0},  {3, 1},   {2, 2},   {1, 3},
                                 {0, 3},  {-1, 3}, {-2, 2}, {-3, 1}, {-3, 0}, {-3, -1}, {-2, -2}, {-1, -3}};
  for (int first = 0; first < 16; ++first) {
    int brighter = 0, darker = 0;
    for (int i = 0; i < 9; ++i) {
      const int* d = circle[(first + i) % 16];
      brighter += image(x + d[0], y + d[1]) > image(x, y) + threshold;
      darker += image(x + d[0], y + d[1]) < image(x, y) - threshold;
    }
    if (brighter == 9 || darker == 9) return true;
  }
  return false;
}

/// (11)
inline double shi_tomasi(const GrayView& image, int x, int y) {
  double xx = 0, xy = 0, yy = 0;
  for (int v = y - 3; v <= y + 3; ++v) {
    for (int u = x - 3; u <= x + 3; ++u) {
      const double gx = (image(u + 1, v) - image(u - 1, v)) / 2.0, gy = (image(u, v + 1) - image(u, v - 1)) / 2.0;
      xx += gx * gx / 49;
      xy += gx * gy / 49;
      yy += gy * gy / 49;
    }
  }
  return (xx + yy) / 2 - std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);
}

}  // namespace plumbline::testing
