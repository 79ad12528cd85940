#pragma once
/// Observation of a point by one frame.                                                       docs/math/point.md

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
  Vec<float, 2> uv = zeros<float, 2>();     ///< corrected to the middle of the frame, see RollingShutter [px]
  [[no_unique_address]] Present<RowDerivative<float, 2>, rolls> derivative;  ///< of uv by the readout time
  Mat<float, 2, 2> L = identity<float, 2>();                        ///< L^T L is the information of uv [1/px^2]
  [[no_unique_address]] Present<InverseDepth<S>, has_depth> depth;  ///< measured depth at the pixel

  const Vec<float, 2>& place() const { return pixel; }
  /// Multiplies the sigma of uv by `scale`.
  void scale_sigma(S scale) { L = L / float(scale); }
  /// Corrects uv for a readout time that is `change_s` longer.
  void change_readout(S change_s) { uv += float(change_s) * derivative.get().by_readout(); }
  /// Corrects uv for another inverse range of the point from this camera [1/m].
  void set_inverse_range(S lambda, S readout_s) {
    RowDerivative<float, 2> changed = derivative.get();
    uv += changed.set_inverse_range(float(lambda), float(readout_s));
    derivative.set(changed);
  }
  /// Corrects uv for another motion of the camera during the readout, that of `shutter`.
  void set_motion(const auto& shutter, S readout_s) {
    RowDerivative<float, 2> changed = derivative.get();
    const RowDerivative<S, 2> moved = shutter.still(cast_to<S>(pixel), S(changed.inverse_range)).derivative;
    uv += changed.set_motion(
        {cast_to<float>(moved.by_rotation), cast_to<float>(moved.by_translation), changed.inverse_range},
        float(readout_s));
    derivative.set(changed);
  }
  /// Multiplies all lengths by `scale`.
  void rescale(S scale) {
    RowDerivative<float, 2> changed = derivative.get();
    changed.rescale(float(scale));
    derivative.set(changed);
  }
};

/// L, upper triangular, of  Sigma = sigma_px^2 I + sigma_intensity^2 H^-1,  H the information of an alignment.     (11)
/// Along an edge the information H, and so the weight, is small.
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
