#pragma once
/// A line in the world with its observation by one frame: rows of pose refinement, which moves the frame alone.
///                                                                                             docs/math/line.md
/// The covariance C of the line is added to that of its residuals,
///   Sigma_r = Sigma + J_line C_w J_line^T,   C_w = M C M^T,  M = d(n_w; v_w)/d theta                            (29)

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/feature/whitened_rows.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "plumbline/residual/world_line.hpp"

namespace plumbline {

/// Observation: segment_observation.hpp.
template <class Observation>
struct LineInWorld {
  using S = typename decltype(Observation::pixels)::S;

  Plucker<S> line;
  Mat<S, 6, 6> covariance;  ///< C_w of (29)
  Observation seen;

  /// Rows of the pixels, whitened by (29).
  WhitenedRows<S, 2> pixel_rows(const BodyView<S>& view) const {
    const LineReprojection<S>& pixels = seen.pixels.measured;
    const auto lin = WorldLine<LineReprojection<S>>{pixels}.linearize(view, line);
    if (!lin.valid) return {};
    return whitened(lin, seen.pixels.covariance);
  }

  /// Root mean square of the unwhitened residual [px].
  double error_px(const BodyView<S>& view) const {
    const Vec<S, 2> r = seen.pixels.measured.residual(line_in_camera(view, line));
    return double(norm(r)) / std::sqrt(2.0);
  }

  /// Rows of a measured depth, whitened by (29).
  WhitenedRows<S, 2> depth_rows(const BodyView<S>& view) const {
    const auto& depth = seen.depth.get();
    const auto lin = WorldLine<LineInverseDepth<S>>{depth.measured}.linearize(view, line);
    if (!lin.valid) return {};
    return whitened(lin, depth.covariance);
  }

 private:
  template <class Linearization>
  WhitenedRows<S, 2> whitened(const Linearization& lin, const Mat<S, 2, 2>& of_measurement) const {
    const Mat<S, 2, 2> widened = of_measurement + lin.J_r_line * covariance * lin.J_r_line.transpose();  // (29)
    const Result<Mat<S, 2, 2>> W = square_root_information(widened);
    if (!W) return {};
    return WhitenedRows<S, 2>::of(*W, lin.r, lin.J_r_pose);
  }
};

}  // namespace plumbline
