#pragma once
/// Initialization of a line: from the depth beside it, or from the planes of two views with parallax. docs/math/line.md

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/landmark.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/geometry/line_depth.hpp"
#include "plumbline/geometry/line_triangulation.hpp"
#include "plumbline/geometry/segment_depth_filter.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

namespace detail {

/// Sets the line of a landmark, in the camera of its anchor; the landmark is located if the line is sound.
template <class Landmark, class S>
void adopt_line(Landmark& landmark, const Line3<S>& line, const Mat<S, 4, 4>& covariance) {
  const LineReprojection<S>& seen = landmark.seen_by_anchor().pixels.measured;
  landmark.geometry.line = line;
  landmark.geometry.covariance = covariance;
  landmark.geometry.set_extent(SE3<S>(), seen.bearing_start, seen.bearing_end);
  landmark.located = landmark.seen_by_anchor().valid && landmark.geometry.is_sound(seen);
}

/// Adds the rows of a measurement by the anchor, by the line.
template <class Measurement>
void add_in_anchor(const SegmentMeasurement<Measurement>& seen, const Line3<typename Measurement::Scalar>& line,
                   DenseNormalEquations<double, 4>& system) {
  const auto lin = AnchoredLine<Measurement>{seen.measured}.linearize_in_anchor(line);
  if (lin.valid) system.add(product(seen.L, lin.J_r_line), product(seen.L, lin.r), 1.0);
}
/// The same for another frame.
template <class Measurement, class S>
void add_in_target(const SegmentMeasurement<Measurement>& seen, const RelativeView<S>& view, const Line3<S>& line,
                   DenseNormalEquations<double, 4>& system) {
  const auto lin = AnchoredLine<Measurement>{seen.measured}.linearize(view, line);
  if (lin.valid) system.add(product(seen.L, lin.J_r_lambda), product(seen.L, lin.r), 1.0);
}

}  // namespace detail

/// Locates the line from the depth measured by the frame in `slot`, which becomes its anchor.
template <class Landmark>
void locate_in_frame(Landmark& landmark, int slot) {
  using S = typename Landmark::Kind::Scalar;
  const auto& seen = landmark.observations[static_cast<std::size_t>(slot)];
  const auto& depth = seen.depth.get();
  const Line3<S> line =
      line_from_depth(depth.measured.m_start, depth.measured.m_end, depth.measured.inverse_depth_measured);
  DenseNormalEquations<double, 4> system;
  detail::add_in_anchor(seen.pixels, line, system);
  detail::add_in_anchor(depth, line, system);
  Mat<double, 4, 4> covariance;
  if (!system.covariance(covariance)) return;
  landmark.anchor = slot;
  detail::adopt_line(landmark, line, cast_to<S>(covariance));
}

/// Locates the line from its edge in the anchor, and edge and depth in the latest frame; without depth from the planes
/// of the two edges.
template <class Landmark, class S>
void locate_line(Landmark& landmark, const RelativeView<S>& latest, const LineTriangulationOptions& options,
                 const SE3<S>& T_latest_anchor) {
  const auto &in_anchor = landmark.seen_by_anchor(), &seen = landmark.current;
  if (const auto& depth = seen.depth.get(); depth.valid) {
    const Vec<S, 2>& inverse_depth = depth.measured.inverse_depth_measured;
    const Mat<S, 3, 3> R_anchor_latest = latest.R_target_anchor().transpose();
    const auto to_anchor = [&](const Vec<S, 3>& p) {
      return Vec<S, 3>(R_anchor_latest * (p - latest.t_target_anchor()));
    };
    Line3<S> line = Line3<S>::through(to_anchor(depth.measured.m_start / inverse_depth[0]),
                                      to_anchor(depth.measured.m_end / inverse_depth[1]));
    Mat<double, 4, 4> covariance;
    bool found = true;
    constexpr int iterations = 3;    // numerics: Gauss-Newton from the measured depth
    constexpr S max_chi2 = S(13.8);  // chi-square quantile 99.9 %, 2 degrees of freedom, as in the window
    for (int iteration = 0; iteration < iterations && found; ++iteration) {
      DenseNormalEquations<double, 4> system;
      Vec<double, 4> step;
      detail::add_in_anchor(in_anchor.pixels, line, system);
      detail::add_in_target(seen.pixels, latest, line, system);
      detail::add_in_target(depth, latest, line, system);
      found = system.solve(step) && system.covariance(covariance);
      if (found) line = line.plus(cast_to<S>(step));
    }
    const AnchoredLine<LineReprojection<S>> pixels{in_anchor.pixels.measured};
    if (found) {
      const Vec<S, 2> r = product(in_anchor.pixels.L, pixels.linearize_in_anchor(line).r);
      if (squared_norm(r) < max_chi2) {
        detail::adopt_line(landmark, line, cast_to<S>(covariance));
      }
    }
  }
  if (landmark.located) return;
  const auto plane_of = [](const auto& observation, const SE3<S>& T_cam_anchor) {
    const LineReprojection<S>& pixels = observation.pixels.measured;
    return LineTriangulationView<S>{T_cam_anchor, pixels.bearing_start, pixels.bearing_end,
                                    std::sqrt(observation.pixels.covariance(0, 0)) * 2 / pixels.px_per_rad.sum()};
  };
  const std::array<LineTriangulationView<S>, 2> views{plane_of(in_anchor, SE3<S>()), plane_of(seen, T_latest_anchor)};
  const auto found = triangulate_line(std::span<const LineTriangulationView<S>>(views), options);
  if (found.valid) detail::adopt_line(landmark, found.line, found.covariance);
}

/// The rays of a segment with their covariance in angles, input of SegmentDepthFilter.
template <class S>
SegmentRays<S> rays_of(const SegmentMeasurement<LineReprojection<S>>& pixels) {
  const LineReprojection<S>& seen = pixels.measured;
  SegmentRays<S> out{seen.bearing_start, seen.bearing_end, pixels.covariance};
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) out.C(i, j) /= seen.px_per_rad[i] * seen.px_per_rad[j];
  }
  return out;
}

/// Locates the line from its edge in the anchor and the filtered inverse ranges of both ends:
///                                                                                             docs/math/direct.md (21)
///   r_i = lambda_i(line) + beta_i delta_i - mu_i,   delta_i = nh . b_i of the anchor's edge                   (21)
template <class Landmark, class S>
void locate_from_ends(Landmark& landmark, const SegmentDepthFilter<S>& filter) {
  const auto& in_anchor = landmark.seen_by_anchor();
  const LineReprojection<S>& seen = in_anchor.pixels.measured;
  const Vec<S, 3>&start = seen.bearing_start, &end = seen.bearing_end;
  const Vec<S, 2> mu(filter.ends()[0].depth.mu, filter.ends()[1].depth.mu);
  const Line3<S> line = Line3<S>::through(start / mu[0], end / mu[1]);
  const LineInverseDepth<S> rays{start / start.z(), end / end.z(), {mu[0] / start.z(), mu[1] / end.z()}};
  const auto depth = AnchoredLine<LineInverseDepth<S>>{rays}.linearize_in_anchor(line);
  const auto edge = AnchoredLine<LineReprojection<S>>{seen}.linearize_in_anchor(line);
  if (!depth.valid || !edge.valid) return;
  DenseNormalEquations<double, 4> system;
  detail::add_in_anchor(in_anchor.pixels, line, system);
  for (int i = 0; i < 2; ++i) {
    const auto& filtered = filter.ends()[std::size_t(i)];
    const S b_z = i == 0 ? start.z() : end.z();
    const Mat<S, 1, 4> J = b_z * block<1, 4>(depth.J_r_line, i, 0) +
                           (filtered.by_anchor / seen.px_per_rad[i]) * block<1, 4>(edge.J_r_line, i, 0);
    system.add(J, Vec<S, 1>(S(0)), 1 / double(filtered.depth.variance));
  }
  Mat<double, 4, 4> covariance;
  if (system.covariance(covariance)) detail::adopt_line(landmark, line, cast_to<S>(covariance));
}

}  // namespace plumbline
