#pragma once
/// Depth sensor: depth images registered to the camera, with a model of their noise.          docs/math/point.md
///
/// Triangulating sensors (structured light, stereo) measure a disparity, in which 1/z is linear:
///   sigma(1/z)^2 = k^2 + (k0/z^2)^2                                                                          (9)
/// with k constant over depth, and k0 [m] for the remaining error at short range.

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

  /// (9) [1/m]
  S sigma_of(S inverse_depth) const {
    const S near = k0 * inverse_depth * inverse_depth;
    return std::sqrt(k * k + near * near);  // (9)
  }

  /// Inverse depth at (u, v) [px]: the median of the valid 3x3 neighbors. Valid with at least five of nine neighbors
  /// and no depth edge between them.
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
    return out;
  }
};

}  // namespace plumbline
