#pragma once
/// Where a line was seen in one frame: the segment, its appearance, and the depth beside it.  docs/math/line.md

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

/// Covariance [px^2] of (9) at both ends of a segment through `peaks` places with independent errors of `rms_px` each,
/// on top of `sigma_px` that no number of places averages out.                                               (28)
inline Mat<float, 2, 2> endpoint_covariance(float sigma_px, float rms_px, float peaks) {
  const float floor = sigma_px * sigma_px, q = rms_px * rms_px / peaks;
  Mat<float, 2, 2> covariance;
  covariance << floor + 4 * q, -2 * q, -2 * q, floor + 4 * q;
  return covariance;
}

/// Two numbers of a line that were measured, at the start and at the end of its segment.
template <class Measurement>
struct SegmentMeasurement {
  using S = typename Measurement::Scalar;

  bool valid = false;
  Measurement measured{zeros<S, 3>(), zeros<S, 3>(), zeros<S, 2>()};
  Mat<S, 2, 2> covariance = zeros<S, 2, 2>();
  Mat<S, 2, 2> L = zeros<S, 2, 2>();  ///< L^T L is its inverse

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

/// Of edges that are followed by their looks.
template <bool has_profile>
struct SeenProfile {
  LineProfile profile;  ///< its appearance in the image
};
template <>
struct SeenProfile<false> {};

template <class S, bool depth_is_measured, bool rolls_, bool has_profile = true>
struct SegmentObservation : SeenProfile<has_profile> {
  static constexpr bool measures_depth = depth_is_measured, rolls = rolls_;
  using Slopes = std::array<RowSlope<S, 3>, 2>;  ///< of the bearings of start and end

  bool valid = false;
  LineSegment segment;                             ///< in the image
  SegmentMeasurement<LineReprojection<S>> pixels;  ///< in the middle of the frame, see RollingShutter [px]
  [[no_unique_address]] Present<Slopes, rolls> slopes;
  [[no_unique_address]] Present<SegmentMeasurement<LineInverseDepth<S>>, depth_is_measured> depth;  ///< [1/m]

  const LineSegment& place() const { return segment; }
  bool has_depth() const { return depth.get().valid; }

  /// Inverse depths at start and end [1/m]; none where the covariance is not positive definite.
  void set_depth(const Vec<S, 2>& inverse_depth, const Mat<S, 2, 2>& covariance) {
    const LineReprojection<S>& seen = pixels.measured;
    if (!(seen.bearing_start.z() > S(0) && seen.bearing_end.z() > S(0))) return forget_depth();
    depth.set({rays_with(seen, inverse_depth), covariance});
  }
  void forget_depth() { depth.set({}); }

  /// All errors of the pixels are `scale` times those expected.
  void scale_sigma(S scale) {
    pixels.covariance = pixels.covariance * (scale * scale);
    pixels.L = pixels.L / scale;
  }

  /// d bearing/d readout of start and end [1/s].
  Mat<S, 3, 2> by_readout() const {
    const Slopes& both = slopes.get();
    Mat<S, 3, 2> out;
    out << both[0].by_readout(), both[1].by_readout();
    return out;
  }
  /// The readout time turned out to be `change_s` longer.
  void change_readout(S change_s) {
    if (!valid) return;
    const Mat<S, 3, 2> slope = by_readout();
    turn(change_s * column(slope, 0), change_s * column(slope, 1));
  }
  /// The line was found to be this one, in this frame's camera.
  void set_line(const Plucker<S>& line, S readout_s) {
    if (!valid) return;
    const LineReprojection<S>& seen = pixels.measured;
    Slopes both = slopes.get();
    const auto change = [&](RowSlope<S, 3>& slope, const Vec<S, 3>& bearing) {
      if (!line_visible(line, bearing)) return zeros<S, 3>();
      const S lambda = S(1) / norm(line.point_along(bearing));
      return lambda > S(0) && lambda < max_inverse_range ? slope.set_inverse_range(lambda, readout_s) : zeros<S, 3>();
    };
    const Vec<S, 3> start = change(both[0], seen.bearing_start), end = change(both[1], seen.bearing_end);
    slopes.set(both);
    turn(start, end);
  }
  /// The camera was found to have moved as this frame's shutter says; returns how the bearings of start and end change.
  Mat<S, 3, 2> set_motion(const auto& shutter, S readout_s) {
    const LineReprojection<S>& seen = pixels.measured;
    Slopes both = slopes.get();
    const auto change = [&](RowSlope<S, 3>& slope, const Vec<float, 2>& pixel, const Vec<S, 3>& bearing) {
      return slope.set_motion(shutter.bearing_slope(cast_to<S>(pixel), bearing, slope.inverse_range), readout_s);
    };
    Mat<S, 3, 2> out;
    out << change(both[0], segment.start, seen.bearing_start), change(both[1], segment.end, seen.bearing_end);
    slopes.set(both);
    turn(column(out, 0), column(out, 1));
    return out;
  }
  /// All lengths become `scale` times what they were.
  void rescale(S scale) {
    Slopes both = slopes.get();
    for (RowSlope<S, 3>& slope : both) slope.rescale(scale);
    slopes.set(both);
  }

 private:
  static constexpr S max_inverse_range = S(20);  ///< [1/m]

  void turn(const Vec<S, 3>& start, const Vec<S, 3>& end) {
    LineReprojection<S>& seen = pixels.measured;
    seen.bearing_start = normalized(seen.bearing_start + start);
    seen.bearing_end = normalized(seen.bearing_end + end);
    if (!has_depth()) return;
    SegmentMeasurement<LineInverseDepth<S>> moved = depth.get();
    moved.measured = rays_with(seen, moved.measured.inverse_depth_measured);
    depth.set(moved);
  }
  static LineInverseDepth<S> rays_with(const LineReprojection<S>& seen, const Vec<S, 2>& inverse_depth) {
    return {seen.bearing_start / seen.bearing_start.z(), seen.bearing_end / seen.bearing_end.z(), inverse_depth};
  }
};

}  // namespace plumbline
