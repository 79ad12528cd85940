#pragma once
/// Depth sensor: depth images registered to the camera, with a model of their noise.          docs/math/point.md
///
/// Triangulating sensors (structured light, stereo) measure a disparity, in which 1/z is linear:
///   sigma(1/z)^2 = k^2 + (k0/z^2)^2                                                                          (9)
/// with k constant over depth, and k0 [m] for the remaining error at short range.
///
/// A corner on the contour of a surface belongs to the nearer of two surfaces, but is detected up to some pixels beside
/// it. On a plane 1/z is linear in the pixel, so the second difference of opposite pixels detects the contour of a
/// nearer surface:
///   bend_d = 1/z(u + d) + 1/z(u - d) - 2/z(u)                                                                (9a)

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"

namespace plumbline {

/// One inverse depth with its standard deviation; `valid` is false in holes, at depth edges and out of range.
template <class S>
struct InverseDepth {
  bool valid = false;
  S value = S(0);  ///< 1/z [1/m]
  S sigma = S(0);  ///< [1/m]
};

/// Noise model, and the measurement at a pixel.
template <class S>
struct DepthSensor {
  S units_per_meter = S(1000);  ///< depth [m] = raw value / units_per_meter; raw value 0: no measurement
  S z_min = S(0.3);             ///< smallest valid depth [m]
  S z_max = S(8);               ///< largest valid depth [m]
  S k = S(6.0e-3);              ///< constant part of (9) [1/m]
  S k0 = S(3.0e-2);             ///< short-range part of (9) [m]: calibration, registration, time stamps
  /// Largest spread of the 3x3 neighbors, in sigmas to either side; beyond it there is a depth edge.
  S edge_sigmas = S(3);
  S contour_sigmas = S(1);  ///< second difference (9a) beyond which a nearer surface begins, in sigmas

  /// (9) [1/m]
  S sigma_of(S inverse_depth) const {
    const S near = k0 * inverse_depth * inverse_depth;
    return std::sqrt(k * k + near * near);  // (9)
  }

  /// Inverse depth at (u, v) [px]: the median of the valid 3x3 neighbors, or that of a nearer surface that begins
  /// within three pixels. Valid with at least five of nine neighbors and no depth edge between them.
  InverseDepth<S> at(const ImageView<const std::uint16_t>& depth, const Vec<float, 2>& uv) const {
    if (depth.empty() || !depth.contains(uv.x(), uv.y(), 1.5f)) return {};
    const int x = static_cast<int>(std::lround(uv.x())), y = static_cast<int>(std::lround(uv.y()));
    std::array<std::uint16_t, 9> raw;
    int n = 0;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const std::uint16_t value = depth(x + dx, y + dy);
        if (value != 0) raw[n++] = value;
      }
    }
    if (n < 5) return {};
    std::sort(raw.begin(), raw.begin() + n);
    const S z = S(raw[n / 2]) / units_per_meter;
    if (!(z >= z_min && z <= z_max)) return {};
    InverseDepth<S> out;
    out.value = S(1) / z;
    out.sigma = sigma_of(out.value);
    const S sigma_z = out.sigma * z * z, spread = S(raw[n - 1] - raw[0]) / units_per_meter;
    out.valid = spread <= 2 * edge_sigmas * sigma_z;
    if (out.valid) out.value = foremost(depth, x, y, out);
    return out;
  }

 private:
  /// Mean inverse depth of the nearer surface, if at least two second differences (9a) exceed their limit and none has
  /// the opposite sign with more than half their mean, as noise would; else the measured one.
  S foremost(const ImageView<const std::uint16_t>& depth, int x, int y, const InverseDepth<S>& measured) const {
    constexpr int far = 3;
    constexpr std::array<std::array<int, 2>, 4> directions{{{far, 0}, {far, far}, {0, far}, {-far, far}}};
    if (!depth.contains(x, y, far)) return measured.value;
    S nearer = S(0), bends = S(0), farthest = S(0);
    int n = 0;
    for (const auto& [dx, dy] : directions) {
      const std::uint16_t raw_a = depth(x + dx, y + dy), raw_b = depth(x - dx, y - dy);
      if (raw_a == 0 || raw_b == 0) continue;
      const S a = units_per_meter / S(raw_a), b = units_per_meter / S(raw_b), bend = a + b - 2 * measured.value;
      farthest = std::min(farthest, bend);
      if (!(bend > contour_sigmas * measured.sigma)) continue;
      nearer += std::max(a, b);
      bends += bend;
      ++n;
    }
    return n >= 2 && -farthest < S(0.5) * bends / S(n) ? nearer / S(n) : measured.value;
  }
};

}  // namespace plumbline
