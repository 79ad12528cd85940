#pragma once
/// A point in the world with its observation by one frame: rows of pose refinement, which moves the frame alone.
///                                                                                            docs/math/point.md
/// The uncertainty of the point is added to that of its residual, along the direction in which it would move the
/// observation,
///   Sigma_uv = (L^T L)^-1 + J_uv_lambda J_uv_lambda^T sigma_lambda^2
///   Sigma_z  = sigma_z^2 + (J_z_lambda sigma_lambda)^2
///   Sigma_uv^-1/2 = (I - c j j^T / |j|^2) L,  j = L J_uv_lambda sigma_lambda,  c = 1 - 1/sqrt(1 + |j|^2)       (10)
/// so that new landmarks with one noisy depth do not dominate those with many observations.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/point_observation.hpp"
#include "plumbline/feature/whitened_rows.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

template <SensorRig Sensors>
struct PointInWorld {
  using S = typename Sensors::Scalar;
  using Observation = PointObservation<S, Sensors::has_depth, Sensors::rolls>;

  Vec<S, 3> p_world;
  Vec<S, 3> sigma_world;  ///< displacement in the world by one sigma of the inverse range [m]
  Observation seen;

  /// Rows of the pixel, whitened by (10).
  WhitenedRows<S, 2> pixel_rows(const Sensors& rig, const BodyView<S>& view) const {
    const auto lin =
        PointReprojection<typename Sensors::Camera>{cast_to<S>(seen.uv)}.linearize(rig.vision.camera, view, p_world);
    if (!lin.valid) return {};
    const Mat<S, 2, 2> L = cast_to<S>(seen.L);
    const Vec<S, 2> j = L * (lin.J_r_point * sigma_world);
    const S jj = squared_norm(j);
    Mat<S, 2, 2> W = L;
    constexpr S least = S(1e-12);  // numerics: below, the shrinkage is zero
    if (jj > least) {
      const S shrink = (S(1) - S(1) / std::sqrt(S(1) + jj)) / jj;
      for (int c = 0; c < 2; ++c) {
        const S along = shrink * (j[0] * L(0, c) + j[1] * L(1, c));
        for (int i = 0; i < 2; ++i) W(i, c) -= along * j[i];  // (10)
      }
    }
    return WhitenedRows<S, 2>::of(W, lin.r, lin.J_r_pose);
  }

  /// Norm of the unwhitened residual [px].
  double error_px(const Sensors& rig, const BodyView<S>& view) const {
    const auto lin =
        PointReprojection<typename Sensors::Camera>{cast_to<S>(seen.uv)}.linearize(rig.vision.camera, view, p_world);
    return lin.valid ? double(norm(lin.r)) : 0;
  }

  /// Whether the frame measured a depth, and its row, whitened by (10).
  bool has_depth() const { return seen.depth.get().valid; }
  WhitenedRows<S, 1> depth_rows(const BodyView<S>& view) const {
    const InverseDepth<S>& measured = seen.depth.get();
    const auto lin = PointInverseDepth<S>{measured.value}.linearize(view, p_world);
    if (!lin.valid) return {};
    S j = S(0);
    for (int c = 0; c < 3; ++c) j += lin.J_r_point(0, c) * sigma_world[c];
    const Mat<S, 1, 1> w(S(1) / std::sqrt(measured.sigma * measured.sigma + j * j));
    return WhitenedRows<S, 1>::of(w, lin.r, lin.J_r_pose);
  }
};

}  // namespace plumbline
