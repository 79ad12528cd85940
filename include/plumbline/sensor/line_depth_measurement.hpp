#pragma once
/// Measurement of the depth of an image segment from the depth image beside it.              docs/math/line.md (26)

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line_depth.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/sensor/depth_sensor.hpp"

namespace plumbline {

struct LineDepthSampling {
  /// Distance of a first sample to the segment [px]: outside mixed pixels and the 3x3 median.
  float near_px = 3.0f;
  float far_px = 8.0f;      ///< distance of a second sample [px], to check that the surface continues
  float spacing_px = 4.0f;  ///< distance of samples along the segment [px], at most 30 positions
  float end_px = 3.0f;      ///< length that is left out at both ends [px]
  LineDepthOptions fit;
};

/// Samples the depth on both sides of the segment from `uv_start` to `uv_end` [px] where the surface is continuous,
/// fits the inverse depth of each side, and returns that of the nearer side at these two pixels.
template <CameraModel Camera>
LineDepth<typename Camera::Scalar> measure_line_depth(const Camera& camera,
                                                      const DepthSensor<typename Camera::Scalar>& sensor,
                                                      const ImageView<const std::uint16_t>& depth,
                                                      const Vec<float, 2>& uv_start, const Vec<float, 2>& uv_end,
                                                      const LineDepthSampling& options = {}) {
  using S = typename Camera::Scalar;
  using Sample = LineDepthSample<S>;
  constexpr std::size_t max_places = 30;
  const auto ray_of = [&](const Vec<float, 2>& uv, Vec<S, 3>& m) {
    const Unprojection<S> ray = camera.unproject(cast_to<S>(uv));
    if (!ray.valid || !(ray.bearing.z() > S(0))) return false;
    m = ray.bearing / ray.bearing.z();
    return true;
  };
  Vec<S, 3> m_start, m_end;
  const float length = norm(uv_end - uv_start), usable = length - 2 * options.end_px;
  if (!(usable > 0) || !ray_of(uv_start, m_start) || !ray_of(uv_end, m_end)) return {};
  const auto sample = [&](const Vec<float, 2>& uv, Sample& out) {
    const InverseDepth<S> measured = sensor.at(depth, uv);
    Vec<S, 3> m;
    if (!measured.valid || !ray_of(uv, m)) return false;
    out = {along_segment(m, m_start, m_end), measured.value, measured.sigma, across_segment(m, m_start, m_end)};
    return true;
  };
  const Vec<float, 2> along = (uv_end - uv_start) / length, across(-along.y(), along.x());
  const int places = static_cast<int>(std::min(usable / options.spacing_px, static_cast<float>(max_places - 1))) + 1;
  std::array<FixedVector<Sample, 2 * max_places>, 2> sides;
  for (int k = 0; k < places; ++k) {
    const float t = options.end_px + usable * (static_cast<float>(k) + 0.5f) / static_cast<float>(places);
    const Vec<float, 2> uv = uv_start + t * along;
    for (std::size_t i = 0; i < 2; ++i) {
      const Vec<float, 2> beside = i == 0 ? Vec<float, 2>(-across) : across;
      Sample near, far;
      if (!sample(uv + options.near_px * beside, near) || !sample(uv + options.far_px * beside, far)) continue;
      const S step = std::abs(far.inverse_depth - near.inverse_depth);
      if (!(step < S(options.fit.inlier_sigmas) * far.sigma)) continue;
      sides[i].push_back(near);
      sides[i].push_back(far);
    }
  }
  const auto fit = [&](const auto& samples) {
    LineDepth<S> out = fit_line_depth(std::span<const LineDepthSample<S>>(samples.data(), samples.size()), options.fit);
    out.valid = out.valid && 3 * samples.size() >= 2 * static_cast<std::size_t>(places);  // too few samples otherwise
    return out;
  };
  return nearer_side(fit(sides[0]), fit(sides[1]));
}

}  // namespace plumbline
