#pragma once
/// Infinite line in the camera of a keyframe (the anchor), with the extent of its observed part.  docs/math/line.md
///
/// In contrast to a point, no observation defines the line: that of the anchor is a measurement like all others.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/residual/line_observation.hpp"

namespace plumbline {

template <class S>
struct LineGeometry {
  Line3<S> line;                               ///< directed from start to end of its segment
  Mat<S, 4, 4> covariance = zeros<S, 4, 4>();  ///< of its increment, the poses fixed
  Vec<S, 2> extent = zeros<S, 2>();            ///< start and end of the part observed last, as in `at` [m]

  /// Point of the line at the distance `along` from the point closest to the camera [m].
  Vec<S, 3> at(S along) const { return line.closest_point() + along * line.direction(); }
  Vec<S, 3> middle() const { return at((extent[0] + extent[1]) / 2); }

  /// Sets start and end of the extent to the points of the line beside two bearings of a camera; an end whose bearing
  /// does not meet the line keeps its value.
  void set_extent(const SE3<S>& T_camera_anchor, const Vec<S, 3>& bearing_start, const Vec<S, 3>& bearing_end) {
    const Plucker<S> in_camera = T_camera_anchor * line.plucker();
    const SE3<S> T_anchor_camera = T_camera_anchor.inverse();
    for (int i = 0; i < 2; ++i) {
      const Vec<S, 3>& bearing = i == 0 ? bearing_start : bearing_end;
      if (!line_visible(in_camera, bearing)) continue;
      const S along = dot(line.direction(), T_anchor_camera * in_camera.point_along(bearing));
      if (std::abs(along) < max_extent) extent[i] = along;  // false for NaN
    }
  }

  /// d(n; v)/d readout of line.plucker() [1/s]: the line moves with the bearings of the anchor's segment, whose
  /// derivatives are given; zero where the line is not visible.                                                    (30)
  Vec<S, 6> derivative(const LineReprojection<S>& seen, const Mat<S, 3, 2>& bearing_derivative) const {
    const Plucker<S> plucker = line.plucker();
    Vec<S, 6> out = zeros<S, 6>();
    if (!line_visible(plucker, seen.bearing_start) || !line_visible(plucker, seen.bearing_end)) return out;
    const Vec<S, 3> p = plucker.point_along(seen.bearing_start), q = plucker.point_along(seen.bearing_end),
                    p_derivative = norm(p) * column(bearing_derivative, 0),
                    q_derivative = norm(q) * column(bearing_derivative, 1);
    const S scale = norm(plucker.v) / norm(q - p);
    out << scale * (p_derivative.cross(q) + p.cross(q_derivative)), scale * (q_derivative - p_derivative);
    return all_finite(out) ? out : zeros<S, 6>();
  }
  /// Adds d to (n; v).
  void change(const Vec<S, 6>& d) {
    const Plucker<S> plucker = line.plucker();
    line = Line3<S>(Plucker<S>{plucker.n + segment<3>(d, 0), plucker.v + segment<3>(d, 3)});
  }

  /// Multiplies all lengths by `scale`.                                                                      (32)
  void rescale(S scale) {
    const S d = line.distance();
    const Plucker<S> plucker = line.plucker();
    line = Line3<S>(Plucker<S>{scale * plucker.n, plucker.v});
    extent = scale * extent;
    const S derivative = scale * (1 + d * d) / (1 + scale * scale * d * d);
    for (int k = 0; k < 4; ++k) covariance(k, 3) *= derivative;
    for (int k = 0; k < 4; ++k) covariance(3, k) *= derivative;
  }

  /// Whether the inverse depths at both ends of the anchor's segment exceed three sigmas, and the line is more than 2
  /// cm from the camera center.
  bool is_sound(const LineReprojection<S>& seen) const {
    if (!(line.distance() > min_distance) || !all_finite(covariance)) return false;
    const LineInverseDepth<S> ends{seen.bearing_start / seen.bearing_start.z(), seen.bearing_end / seen.bearing_end.z(),
                                   zeros<S, 2>()};
    const auto inverse_depth = AnchoredLine<LineInverseDepth<S>>{ends}.linearize_in_anchor(line);
    if (!inverse_depth.valid) return false;
    for (int i = 0; i < 2; ++i) {
      const Mat<S, 1, 4> J = block<1, 4>(inverse_depth.J_r_line, i, 0);
      const S variance = product_transposed(product(J, covariance), J)(0, 0);
      if (!(inverse_depth.r[i] > min_significance * std::sqrt(variance))) return false;
    }
    return true;
  }

 private:
  static constexpr S min_distance = S(0.02);   ///< of a sound line [m]; geometry: no camera focuses nearer
  static constexpr S min_significance = S(3);  ///< chi-square quantile 99.7 %, 1 degree of freedom
  static constexpr S max_extent = S(1e3);      ///< largest accepted |extent| [m]; geometry: no parallax beyond
};

}  // namespace plumbline
