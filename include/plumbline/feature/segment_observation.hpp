#pragma once
/// Observation of a line by one frame: the segment, its appearance, and the measured depth.   docs/math/line.md

#include <array>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"
#include "plumbline/tracking/line_profile.hpp"
#include "plumbline/tracking/line_segment.hpp"

namespace plumbline {

/// Covariance [px^2] of (9) at both ends of a segment that is fitted to `peaks` edge points with independent errors of
/// `rms_px` each, plus a common error of `sigma_px`.                                                         (28)
inline Mat<float, 2, 2> endpoint_covariance(float sigma_px, float rms_px, float peaks) {
  const float floor = sigma_px * sigma_px, q = rms_px * rms_px / peaks;
  Mat<float, 2, 2> covariance;
  covariance << floor + 4 * q, -2 * q, -2 * q, floor + 4 * q;
  return covariance;
}

/// Measurement of a line at the two ends of its segment, with its covariance.
template <class Measurement>
struct SegmentMeasurement {
  using S = typename Measurement::Scalar;

  bool valid = false;
  Measurement measured{zeros<S, 3>(), zeros<S, 3>(), zeros<S, 2>()};
  Mat<S, 2, 2> covariance = zeros<S, 2, 2>();
  Mat<S, 2, 2> L = zeros<S, 2, 2>();  ///< L^T L is the inverse covariance

  SegmentMeasurement() = default;
  /// Not valid where the covariance is not positive definite.
  SegmentMeasurement(const Measurement& measurement, const Mat<S, 2, 2>& covariance_of_it) {
    const Result<Mat<S, 2, 2>> root = square_root_information(covariance_of_it);
    valid = bool(root);
    if (!valid) return;
    measured = measurement;
    covariance = covariance_of_it;
    L = *root;
  }
};

/// Image profile of an edge, for kinds that are tracked by appearance.
template <bool has_profile>
struct SeenProfile {
  LineProfile profile;  ///< intensity profile across the edge
};
template <>
struct SeenProfile<false> {};

template <class S, bool depth_is_measured, bool rolls_, bool has_profile = true>
struct SegmentObservation : SeenProfile<has_profile> {
  static constexpr bool measures_depth = depth_is_measured, rolls = rolls_;
  using Derivatives = std::array<RowDerivative<S, 3>, 2>;  ///< of the bearings of start and end by the readout time

  bool valid = false;
  LineSegment segment;                             ///< as measured in the image [px]
  SegmentMeasurement<LineReprojection<S>> pixels;  ///< corrected to the middle of the frame, see RollingShutter [px]
  [[no_unique_address]] Present<Derivatives, rolls> derivatives;
  [[no_unique_address]] Present<SegmentMeasurement<LineInverseDepth<S>>, depth_is_measured> depth;  ///< [1/m]

  const LineSegment& place() const { return segment; }
  bool has_depth() const { return depth.get().valid; }

  /// Sets the inverse depths at start and end [1/m]; not valid where the covariance is not positive definite.
  void set_depth(const Vec<S, 2>& inverse_depth, const Mat<S, 2, 2>& covariance) {
    const LineReprojection<S>& seen = pixels.measured;
    if (!(seen.bearing_start.z() > S(0) && seen.bearing_end.z() > S(0))) return clear_depth();
    depth.set({rays_with(seen, inverse_depth), covariance});
  }
  void clear_depth() { depth.set({}); }

  /// Multiplies the sigmas of the pixels by `scale`.
  void scale_sigma(S scale) {
    pixels.covariance = pixels.covariance * (scale * scale);
    pixels.L = pixels.L / scale;
  }

  /// d bearing/d readout of start and end [1/s].
  Mat<S, 3, 2> by_readout() const {
    const Derivatives& both = derivatives.get();
    Mat<S, 3, 2> out;
    out << both[0].by_readout(), both[1].by_readout();
    return out;
  }
  /// Corrects both bearings for a readout time that is `change_s` longer.
  void change_readout(S change_s) {
    if (!valid) return;
    const Mat<S, 3, 2> derivative = by_readout();
    move_bearings(change_s * column(derivative, 0), change_s * column(derivative, 1));
  }
  /// Corrects both bearings for the ranges of the line, given in the camera of this frame.
  void set_line(const Plucker<S>& line, S readout_s) {
    if (!valid) return;
    const LineReprojection<S>& seen = pixels.measured;
    Derivatives both = derivatives.get();
    const auto change = [&](RowDerivative<S, 3>& derivative, const Vec<S, 3>& bearing) {
      if (!line_visible(line, bearing)) return zeros<S, 3>();
      const S lambda = S(1) / norm(line.point_along(bearing));
      return lambda > S(0) && lambda < max_inverse_range ? derivative.set_inverse_range(lambda, readout_s)
                                                         : zeros<S, 3>();
    };
    const Vec<S, 3> start = change(both[0], seen.bearing_start), end = change(both[1], seen.bearing_end);
    derivatives.set(both);
    move_bearings(start, end);
  }
  /// Corrects both bearings for another motion of the camera during the readout, that of `shutter`; returns their
  /// changes.
  Mat<S, 3, 2> set_motion(const auto& shutter, S readout_s) {
    const LineReprojection<S>& seen = pixels.measured;
    Derivatives both = derivatives.get();
    const auto change = [&](RowDerivative<S, 3>& derivative, const Vec<float, 2>& pixel, const Vec<S, 3>& bearing) {
      return derivative.set_motion(shutter.bearing_derivative(cast_to<S>(pixel), bearing, derivative.inverse_range),
                                   readout_s);
    };
    Mat<S, 3, 2> out;
    out << change(both[0], segment.start, seen.bearing_start), change(both[1], segment.end, seen.bearing_end);
    derivatives.set(both);
    move_bearings(column(out, 0), column(out, 1));
    return out;
  }
  /// Multiplies all lengths by `scale`.
  void rescale(S scale) {
    Derivatives both = derivatives.get();
    for (RowDerivative<S, 3>& derivative : both) derivative.rescale(scale);
    derivatives.set(both);
  }

 private:
  static constexpr S max_inverse_range = S(20);  ///< largest accepted inverse range [1/m]; geometry: 5 cm

  /// Adds changes to the bearings of start and end.
  void move_bearings(const Vec<S, 3>& start, const Vec<S, 3>& end) {
    LineReprojection<S>& seen = pixels.measured;
    seen.bearing_start = normalized(seen.bearing_start + start);
    seen.bearing_end = normalized(seen.bearing_end + end);
    if (!has_depth()) return;
    SegmentMeasurement<LineInverseDepth<S>> moved = depth.get();
    moved.measured = rays_with(seen, moved.measured.inverse_depth_measured);
    depth.set(moved);
  }
  /// Measurement of inverse depths on the rays of a segment.
  static LineInverseDepth<S> rays_with(const LineReprojection<S>& seen, const Vec<S, 2>& inverse_depth) {
    return {seen.bearing_start / seen.bearing_start.z(), seen.bearing_end / seen.bearing_end.z(), inverse_depth};
  }
};

}  // namespace plumbline
