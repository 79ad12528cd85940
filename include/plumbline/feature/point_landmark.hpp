#pragma once
/// A point landmark: inverse range along the unit bearing of its first observation (the anchor), the observations of it
/// in the keyframes of the window, and the pixels it is recognized by.                     docs/math/point.md

#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/depth_sensor.hpp"
#include "plumbline/tracking/reference_patch.hpp"

namespace plumbline {

/// Where a landmark was seen in one frame.
template <class S>
struct PointObservation {
  bool valid = false;
  Vec<float, 2> pixel = Vec<float, 2>::Zero();        ///< in the image [px]
  Vec<float, 2> uv = Vec<float, 2>::Zero();           ///< in the middle of the frame, see RollingShutter [px]
  Vec<float, 2> uv_slope = Vec<float, 2>::Zero();     ///< d uv / d readout [px/s]
  Mat<float, 2, 2> L = Mat<float, 2, 2>::Identity();  ///< L^T L is the information of uv [1/px^2]
  InverseDepth<S> depth;                              ///< of the pixel, where the sensor has one
};

/// L of  Sigma = sigma_px^2 I + sigma_intensity^2 (J^T J)^-1,  the information that an alignment measured.       (11)
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

template <class S, int Slots>
struct PointLandmark {
  std::uint32_t id = 0;
  int anchor = 0;                                         ///< slot of the keyframe whose camera the bearing belongs to
  Vec<S, 3> bearing = Vec<S, 3>::UnitZ();                 ///< unit, anchor camera
  Vec<S, 3> bearing_slope = Vec<S, 3>::Zero();            ///< d bearing / d readout [1/s]
  bool located = false;                                   ///< the inverse range is known
  S inverse_range = S(0);                                 ///< lambda [1/m]
  S sigma_inverse_range = S(0);                           ///< given the poses [1/m]
  std::array<PointObservation<S>, Slots> observations{};  ///< in the keyframes, by slot
  PointObservation<S> current;                            ///< in the latest frame
  PointObservation<S> previous;                           ///< in the one before
  int misses = 0;                                         ///< consecutive frames that should have seen it and did not
  ReferencePatch patch;                                   ///< its appearance in the anchor

  int observation_count() const {
    int n = 0;
    for (const PointObservation<S>& observation : observations) n += observation.valid;
    return n;
  }
  Vec<S, 3> p_anchor_cam() const { return bearing / inverse_range; }
};

}  // namespace plumbline
