#pragma once
/// Light of a simulated room, computed once: Lambertian surfaces, so that every view of a point has the same intensity.
///
///   E(p) = (0.75 + 0.6 (1 + n . l)/2) (1 - 0.75 O(p)),  O = mean over the hemisphere of max(0, 1 - d/d_max)
///
/// with d the distance to the next surface: one soft directional light and the darkening toward corners and under
/// boards.

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "plumbline/testing/scene.hpp"

namespace plumbline::testing {

/// Irradiance over one rectangle on a coarse grid, interpolated bilinearly.
class LightMap {
 public:
  static constexpr double fine = 0.15;  ///< [m] a good spacing of the grid

  LightMap(const Scene& scene, const Rectangle& r, double spacing) {
    const auto cells = [&](double length) { return std::max(1, static_cast<int>(std::lround(length / spacing))); };
    columns_ = cells(r.width) + 1;
    rows_ = cells(r.height) + 1;
    per_u_ = static_cast<float>((columns_ - 1) / r.width);
    per_v_ = static_cast<float>((rows_ - 1) / r.height);
    const Vec<double, 3> n = r.normal(), light = Vec<double, 3>(0.45, -0.3, 0.84);
    const double inset = std::min(0.015, std::min(r.width, r.height) / 4);
    const double direct = 0.75 + 0.3 * (1 + n.dot(light));
    for (int j = 0; j < rows_; ++j) {
      for (int i = 0; i < columns_; ++i) {  // samples on the border are drawn in, off the edge shared with a neighbor
        const double u = std::clamp(i / static_cast<double>(per_u_), inset, r.width - inset);
        const double v = std::clamp(j / static_cast<double>(per_v_), inset, r.height - inset);
        const Vec<double, 3> p = r.origin + u * r.e_u + v * r.e_v + 1e-4 * n;
        values_.push_back(static_cast<float>(direct * (1 - 0.75 * occlusion(scene, p, r))));
      }
    }
  }

  float at(float u, float v) const {
    const float x = std::clamp(u * per_u_, 0.0f, static_cast<float>(columns_ - 1) - 1e-3f);
    const float y = std::clamp(v * per_v_, 0.0f, static_cast<float>(rows_ - 1) - 1e-3f);
    const int x0 = static_cast<int>(x), y0 = static_cast<int>(y);
    const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
    const float* p = values_.data() + y0 * columns_ + x0;
    return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * p[columns_] + a * p[columns_ + 1]);
  }

 private:
  static constexpr double d_max = 1.0;  ///< [m]

  /// O(p) with 16 cosine-distributed rays, the same for all points.
  static double occlusion(const Scene& scene, const Vec<double, 3>& p, const Rectangle& r) {
    constexpr int count = 16;
    double sum = 0;
    for (int k = 0; k < count; ++k) {
      const double s2 = (k + 0.5) / count, angle = k * std::numbers::pi * (3 - std::sqrt(5.0)), s = std::sqrt(s2);
      const Vec<double, 3> ray =
          s * std::cos(angle) * r.e_u + s * std::sin(angle) * r.e_v + std::sqrt(1 - s2) * r.normal();
      sum += std::max(0.0, 1 - scene.intersect(p, ray) / d_max);
    }
    return sum / count;
  }

  int columns_, rows_;
  float per_u_, per_v_;  ///< [cells/m]
  std::vector<float> values_;
};

}  // namespace plumbline::testing
