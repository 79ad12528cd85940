#pragma once
/// Where a point was seen in one frame.                                                       docs/math/point.md

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/sensor/depth_sensor.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

template <class S, bool has_depth, bool rolls>
struct PointObservation {
  bool valid = false;
  Vec<float, 2> pixel = zeros<float, 2>();  ///< in the image [px]
  Vec<float, 2> uv = zeros<float, 2>();     ///< in the middle of the frame, see RollingShutter [px]
  [[no_unique_address]] Present<RowSlope<float, 2>, rolls> slope;   ///< of uv
  Mat<float, 2, 2> L = identity<float, 2>();                        ///< L^T L is the information of uv [1/px^2]
  [[no_unique_address]] Present<InverseDepth<S>, has_depth> depth;  ///< of the pixel, where there is one

  const Vec<float, 2>& place() const { return pixel; }
  /// All errors are `scale` times those expected.
  void scale_sigma(S scale) { L = L / float(scale); }
  /// The readout time turned out to be `change_s` longer.
  void change_readout(S change_s) { uv += float(change_s) * slope.get().by_readout(); }
  /// The point was found to be that far from this frame's camera.
  void set_inverse_range(S lambda, S readout_s) {
    RowSlope<float, 2> changed = slope.get();
    uv += changed.set_inverse_range(float(lambda), float(readout_s));
    slope.set(changed);
  }
  /// The camera was found to have moved as this frame's shutter says.
  void set_motion(const auto& shutter, S readout_s) {
    RowSlope<float, 2> changed = slope.get();
    const RowSlope<S, 2> moved = shutter.still(cast_to<S>(pixel), S(changed.inverse_range)).slope;
    uv += changed.set_motion({cast_to<float>(moved.by_turn), cast_to<float>(moved.by_shift), changed.inverse_range},
                             float(readout_s));
    slope.set(changed);
  }
  /// All lengths become `scale` times what they were.
  void rescale(S scale) {
    RowSlope<float, 2> changed = slope.get();
    changed.rescale(float(scale));
    slope.set(changed);
  }
};

/// L of  Sigma = sigma_px^2 I + sigma_intensity^2 H^-1,  H the information that an alignment measured.           (11)
/// Edges are known across and unknown along: what is not measured does not count.
inline Mat<float, 2, 2> whitening_of(const Mat<float, 2, 2>& information_per_intensity, float sigma_px,
                                     float sigma_intensity) {
  const Mat<float, 2, 2>& A = information_per_intensity;
  const float det = A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0), q = sigma_intensity * sigma_intensity / det;
  const float a = sigma_px * sigma_px + q * A(1, 1), b = -q * A(0, 1), c = sigma_px * sigma_px + q * A(0, 0);
  const float det_sigma = a * c - b * b;  // Sigma = [a b; b c], L its inverse's Cholesky factor
  Mat<float, 2, 2> L;
  L << std::sqrt(c / det_sigma), -b / std::sqrt(c * det_sigma), 0.0f, 1.0f / std::sqrt(c);
  return L;
}

}  // namespace plumbline
