#pragma once
/// The depth of an image segment from the depth image around it.                            docs/math/line.md (26)

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
  float side_px = 3.0f;     ///< distance to the segment: clear of mixed pixels and of the 3x3 of the depth image
  float spacing_px = 2.0f;  ///< along the segment, at most 60 samples
  float end_px = 3.0f;      ///< left out at both ends
  LineDepthOptions fit;
};

/// Samples both sides of the segment from `uv_start` to `uv_end` [px] and fits the inverse depth of each; that of the
/// result belongs to these two pixels.
template <CameraModel Camera>
LineDepth<typename Camera::Scalar> measure_line_depth(const Camera& camera,
                                                      const DepthSensor<typename Camera::Scalar>& sensor,
                                                      const ImageView<const std::uint16_t>& depth,
                                                      const Vec<float, 2>& uv_start, const Vec<float, 2>& uv_end,
                                                      const LineDepthSampling& options = {}) {
  using S = typename Camera::Scalar;
  constexpr std::size_t max_samples = 60;
  const auto ray_of = [&](const Vec<float, 2>& uv, Vec<S, 3>& m) {
    const Unprojection<S> ray = camera.unproject(cast_to<S>(uv));
    if (!ray.valid || !(ray.bearing.z() > S(0))) return false;
    m = ray.bearing / ray.bearing.z();
    return true;
  };
  Vec<S, 3> m_start, m_end, m;
  const float length = norm(uv_end - uv_start), usable = length - 2 * options.end_px;
  if (!(usable > 0) || !ray_of(uv_start, m_start) || !ray_of(uv_end, m_end)) return {};
  const Vec<float, 2> along = (uv_end - uv_start) / length,
                      side(-options.side_px * along.y(), options.side_px * along.x());
  const int places = static_cast<int>(std::min(usable / options.spacing_px, static_cast<float>(max_samples - 1))) + 1;
  std::array<FixedVector<LineDepthSample<S>, max_samples>, 2> sides;
  for (int k = 0; k < places; ++k) {
    const float t = options.end_px + usable * (static_cast<float>(k) + 0.5f) / static_cast<float>(places);
    const Vec<float, 2> uv = uv_start + t * along;
    if (!ray_of(uv, m)) continue;
    const S s = along_segment(m, m_start, m_end);
    for (std::size_t i = 0; i < 2; ++i) {
      const InverseDepth<S> beside = sensor.at(depth, i == 0 ? uv - side : uv + side);
      if (beside.valid) sides[i].push_back({s, beside.value, beside.sigma});
    }
  }
  const auto fit = [&](const auto& samples) {
    LineDepth<S> out = fit_line_depth(std::span<const LineDepthSample<S>>(samples.data(), samples.size()), options.fit);
    out.valid = out.valid && 3 * samples.size() >= static_cast<std::size_t>(places);  // holes all along say nothing
    return out;
  };
  return nearer_side(fit(sides[0]), fit(sides[1]));
}

}  // namespace plumbline
