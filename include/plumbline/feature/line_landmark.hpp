#pragma once
/// A line landmark: an infinite line in the camera of a keyframe (the anchor), the part of it that was seen, and its
/// observations in the keyframes of the window.                                             docs/math/line.md
///
/// In contrast to a point, no observation defines the line: the anchor's own is a measurement like all others.

#include <array>
#include <cmath>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/residual/line_observation.hpp"
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

/// Where a landmark was seen in one frame.
template <class S>
struct SegmentObservation {
  bool valid = false;
  LineSegment segment;  ///< in the image
  LineProfile profile;  ///< its appearance there
  /// In the middle of the frame, see RollingShutter.
  LineReprojection<S> pixels{Vec<S, 3>::Zero(), Vec<S, 3>::Zero(), Vec<S, 2>::Zero()};
  Mat<S, 2, 2> pixels_covariance = Mat<S, 2, 2>::Zero();  ///< [px^2]
  Mat<S, 2, 2> pixels_L = Mat<S, 2, 2>::Zero();           ///< L^T L is its inverse
  Mat<S, 3, 2> bearing_slope = Mat<S, 3, 2>::Zero();      ///< d bearing / d readout of start and end [1/s]
  bool has_depth = false;
  LineInverseDepth<S> depth{Vec<S, 3>::Zero(), Vec<S, 3>::Zero(), Vec<S, 2>::Zero()};
  Mat<S, 2, 2> depth_covariance = Mat<S, 2, 2>::Zero();  ///< [1/m^2]
  Mat<S, 2, 2> depth_L = Mat<S, 2, 2>::Zero();

  /// False, and no change, when the covariance is not positive definite.
  bool set_pixels(const LineReprojection<S>& measurement, const Mat<S, 2, 2>& covariance) {
    const Result<Mat<S, 2, 2>> L = square_root_information(covariance);
    if (!L) return false;
    pixels = measurement;
    pixels_covariance = covariance;
    pixels_L = *L;
    return true;
  }
  /// Inverse depths at start and end [1/m]; none where the covariance is not positive definite.
  void set_depth(const Vec<S, 2>& inverse_depth, const Mat<S, 2, 2>& covariance) {
    const Result<Mat<S, 2, 2>> L = square_root_information(covariance);
    has_depth = bool(L) && pixels.bearing_start.z() > S(0) && pixels.bearing_end.z() > S(0);
    if (!has_depth) return;
    depth = {pixels.bearing_start / pixels.bearing_start.z(), pixels.bearing_end / pixels.bearing_end.z(),
             inverse_depth};
    depth_covariance = covariance;
    depth_L = *L;
  }

  /// All errors of the pixels are `scale` times those expected.
  void scale_sigma(S scale) {
    pixels_covariance *= scale * scale;
    pixels_L /= scale;
  }

  /// The readout time turned out to be `change_s` longer.
  void change_readout(S change_s) {
    if (!valid) return;
    pixels.bearing_start = (pixels.bearing_start + change_s * bearing_slope.col(0)).normalized();
    pixels.bearing_end = (pixels.bearing_end + change_s * bearing_slope.col(1)).normalized();
    if (!has_depth) return;
    depth.m_start = pixels.bearing_start / pixels.bearing_start.z();
    depth.m_end = pixels.bearing_end / pixels.bearing_end.z();
  }
};

template <class S, int Slots>
struct LineLandmark {
  std::uint32_t id = 0;
  int anchor = 0;                                           ///< slot of the keyframe whose camera the line belongs to
  bool located = false;                                     ///< the line is known
  Line3<S> line;                                            ///< anchor camera, from start to end
  Mat<S, 4, 4> covariance = Mat<S, 4, 4>::Zero();           ///< of its increment, given the poses
  Vec<S, 2> extent = Vec<S, 2>::Zero();                     ///< start and end of what was seen last, see `at` [m]
  std::array<SegmentObservation<S>, Slots> observations{};  ///< in the keyframes, by slot
  SegmentObservation<S> current;                            ///< in the latest frame
  SegmentObservation<S> previous;                           ///< in the one before
  int misses = 0;                                           ///< consecutive frames that should have seen it and did not
  LineProfile profile;                                      ///< of the latest observation that fits
  float gradient = 0;                                       ///< of the same [intensity/px]

  int observation_count() const {
    int n = 0;
    for (const SegmentObservation<S>& observation : observations) n += observation.valid;
    return n;
  }
  const SegmentObservation<S>& seen_by_anchor() const { return observations[static_cast<std::size_t>(anchor)]; }

  /// The point of the line `along` from the one that is nearest to the anchor's camera, in that camera [m].
  Vec<S, 3> at(S along) const { return line.closest_point() + along * line.direction(); }
  Vec<S, 3> middle() const { return at((extent[0] + extent[1]) / 2); }

  /// Sets the extent to what bearings [this line's camera: T_camera_anchor] of start and end see of the line; no change
  /// where they see none of it.
  void set_extent(const SE3<S>& T_camera_anchor, const Vec<S, 3>& bearing_start, const Vec<S, 3>& bearing_end) {
    const Plucker<S> in_camera = T_camera_anchor * line.plucker();
    const SE3<S> T_anchor_camera = T_camera_anchor.inverse();
    for (int i = 0; i < 2; ++i) {
      const Vec<S, 3>& bearing = i == 0 ? bearing_start : bearing_end;
      if (!line_visible(in_camera, bearing)) continue;
      const S along = line.direction().dot(T_anchor_camera * in_camera.point_along(bearing));
      if (std::abs(along) < max_extent) extent[i] = along;  // false for NaN
    }
  }

  /// d(n; v)/d readout of line.plucker() [1/s]: it turns with the bearings of the anchor's segment.           (30)
  Vec<S, 6> line_slope() const {
    const SegmentObservation<S>& seen = seen_by_anchor();
    const Plucker<S> plucker = line.plucker();
    Vec<S, 6> slope = Vec<S, 6>::Zero();
    if (!seen.valid || !line_visible(plucker, seen.pixels.bearing_start) ||
        !line_visible(plucker, seen.pixels.bearing_end)) {
      return slope;
    }
    const Vec<S, 3> p = plucker.point_along(seen.pixels.bearing_start),
                    q = plucker.point_along(seen.pixels.bearing_end), p_slope = p.norm() * seen.bearing_slope.col(0),
                    q_slope = q.norm() * seen.bearing_slope.col(1);
    const S scale = plucker.v.norm() / (q - p).norm();
    slope << scale * (p_slope.cross(q) + p.cross(q_slope)), scale * (q_slope - p_slope);
    return slope.allFinite() ? slope : Vec<S, 6>(Vec<S, 6>::Zero());
  }

  void change_readout(S change_s) {
    if (located) {
      const Plucker<S> plucker = line.plucker();
      const Vec<S, 6> change = change_s * line_slope();
      line = Line3<S>(Plucker<S>{plucker.n + segment<3>(change, 0), plucker.v + segment<3>(change, 3)});
    }
    current.change_readout(change_s);
    for (SegmentObservation<S>& seen : observations) seen.change_readout(change_s);
  }

  /// All lengths become `scale` times what they were.                                                        (32)
  void rescale(S scale) {
    const S d = line.distance();
    const Plucker<S> plucker = line.plucker();
    line = Line3<S>(Plucker<S>{scale * plucker.n, plucker.v});
    extent *= scale;
    const S slope = scale * (1 + d * d) / (1 + scale * scale * d * d);
    covariance.col(3) *= slope;
    covariance.row(3) *= slope;
  }

  /// The distances of both ends of the anchor's segment are known to a third, and the line keeps clear of the camera.
  bool is_sound() const {
    const SegmentObservation<S>& seen = seen_by_anchor();
    if (!seen.valid || !(line.distance() > S(0.02)) || !all_finite(covariance)) return false;
    const LineInverseDepth<S> ends{seen.pixels.bearing_start / seen.pixels.bearing_start.z(),
                                   seen.pixels.bearing_end / seen.pixels.bearing_end.z(), Vec<S, 2>::Zero()};
    const auto inverse_depth = AnchoredLine<LineInverseDepth<S>>{ends}.linearize_in_anchor(line);
    if (!inverse_depth.valid) return false;
    for (int i = 0; i < 2; ++i) {
      const Mat<S, 1, 4> J = block<1, 4>(inverse_depth.J_r_line, i, 0);
      const S variance = product_transposed(product(J, covariance), J)(0, 0);
      if (!(inverse_depth.r[i] > 3 * std::sqrt(variance))) return false;
    }
    return true;
  }

 private:
  static constexpr S max_extent = S(1e3);  ///< [m]
};

}  // namespace plumbline
