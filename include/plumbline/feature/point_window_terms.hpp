#pragma once
/// What the points add to a window's cost: their rows, eliminated one landmark at a time.   docs/math/window.md
///
///   cost = 1/2 sum rho(|r_uv|^2 / sigma_px^2) + 1/2 sum rho(r_z^2 / sigma_z^2)
/// over reprojections in every keyframe but the anchor and inverse depths measured in every keyframe, anchor included.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/point_landmark.hpp"
#include "plumbline/mapping/window_views.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <SensorRig Sensors, class Map, int BlockDim>
class PointWindowTerms {
 public:
  using S = typename Sensors::Scalar;
  using Window = typename Map::Window;
  using Landmark = typename Map::Landmark;
  using Views = WindowViews<S, Window::slots>;
  static constexpr int slots = Window::slots;
  static constexpr int rows_per_view = Sensors::has_depth ? 3 : 2;
  static constexpr int max_rows = rows_per_view * slots;
  using Elimination = LandmarkElimination<S, 1, BlockDim, slots, max_rows>;
  using Pairs = typename Elimination::Pairs;
  static constexpr S lambda_min = S(1e-3), lambda_max = S(20);  ///< inverse range stays in this interval [1/m]

  /// True when a landmark takes part: located and seen by a keyframe besides its anchor.
  static bool takes_part(const Landmark& landmark) { return landmark.located && landmark.observation_count() >= 2; }

  /// Linearizes all landmarks at the current state, adds their rows to `pairs` and returns their cost.
  double linearize(const Sensors& rig, const Map& map, const Window& window, const Views& views, Pairs& pairs) {
    double cost = 0;
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      eliminations_[i].reset();
      if (!takes_part(landmark)) continue;
      cost += add_rows(rig, landmark, window, views, eliminations_[i]);
      eliminations_[i].add_to(pairs);
    }
    return cost;
  }

  /// Eliminates all landmarks with damping `mu`: takes from the normal equations what `pairs` has too much.
  template <class Equations>
  bool eliminate(const Map& map, S mu, const Pairs& pairs, Equations& equations) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      if (eliminations_[i].rows() == 0) continue;
      if (!eliminations_[i].eliminate(mu, pairs)) return false;
      eliminations_[i].subtract_from(equations);
    }
    return true;
  }

  /// The landmarks' steps that belong to the poses' step d; returns what they add to the predicted decrease.
  template <class Vector>
  double solve(const Map& map, const Vector& d) {
    double predicted = 0;
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      steps_[i] = S(0);
      if (eliminations_[i].rows() == 0) continue;
      const Vec<S, 1> dl = eliminations_[i].back_substitute(d, Sensors::state_dim);
      predicted += eliminations_[i].predicted_decrease(dl);
      steps_[i] = dl(0);
    }
    return predicted;
  }

  /// Makes those steps; `restore` takes them back.
  void step(Map& map) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      S& lambda = map.landmarks()[i].inverse_range;
      backup_[i] = lambda;
      if (steps_[i] != S(0)) lambda = std::clamp(lambda + steps_[i], lambda_min, lambda_max);
    }
  }
  void restore(Map& map) const {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) map.landmarks()[i].inverse_range = backup_[i];
  }

  /// The cost alone, at the current state.
  double cost(const Sensors& rig, const Map& map, const Window& window, const Views& views) const {
    double sum = 0;
    for (const Landmark& landmark : map.landmarks()) {
      if (!takes_part(landmark)) continue;
      for (int slot = 0; slot < slots; ++slot) {
        const PointObservation<S>& seen = landmark.observations[slot];
        if (!seen.valid || !window[slot].used) continue;
        if (slot == landmark.anchor) {
          if (seen.depth.valid) sum += depth_loss_.rho(square(anchor_depth_error(landmark))) / 2;
          continue;
        }
        const Vec<S, 3> P = views(landmark.anchor, slot).scaled_point(landmark.bearing, landmark.inverse_range);
        const Projection<S> projection = rig.vision.camera.project(P);
        sum += projection.valid ? cost_of(errors_of(seen, projection, landmark.inverse_range / P.z())) : invalid_cost;
      }
    }
    return sum;
  }

  /// After convergence: observations that do not belong, and the landmarks' standard deviations given the poses.
  void finish(const Sensors& rig, Map& map, const Window& window, const Views& views) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      Landmark& landmark = map.landmarks()[i];
      if (!takes_part(landmark)) continue;
      S information = S(0);  // on lambda, the poses given
      for (int slot = 0; slot < slots; ++slot) {
        PointObservation<S>& seen = landmark.observations[slot];
        if (!seen.valid || !window[slot].used) continue;
        if (slot == landmark.anchor) {
          const S r = anchor_depth_error(landmark);
          if (seen.depth.valid) {
            information += depth_loss_.weight(r * r) / square(seen.depth.sigma * landmark.bearing.z());
          }
          continue;
        }
        const ViewRows lin = linearize_view(rig, landmark, slot, views);
        seen.valid = lin.pixel_chi2 < drop_chi2;
        if (seen.valid && lin.valid) information += lin.J_r_lambda.squaredNorm();
      }
      if (information > S(0)) landmark.sigma_inverse_range = S(1) / std::sqrt(information);
    }
  }

  /// Gives `take` what would be lost with the keyframe in `slot`, landmark by landmark: all rows of those anchored in
  /// it; of the others, which stay, the rows of their observation there, with an inverse range of its own. That
  /// forgets how the observation refined the landmark, but not how it ties the two keyframes together. Residuals are
  /// those of the current state.
  void for_each_leaving(int slot, const Sensors& rig, const Map& map, const Window& window, const Views& views,
                        auto&& take) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      if (!takes_part(landmark)) continue;
      if (landmark.anchor == slot) {
        add_rows(rig, landmark, window, views, eliminations_[i]);
      } else {
        eliminations_[i].reset(landmark.anchor);
        if (landmark.observations[slot].valid) add_view(rig, landmark, slot, views, eliminations_[i]);
      }
      if (eliminations_[i].rows() > 0) take(std::as_const(eliminations_[i]));
    }
  }

 private:
  static constexpr double invalid_cost = 100;  ///< of an observation that the current state cannot explain at all
  static constexpr S drop_chi2 = S(25);        ///< whitened squared error beyond which an observation is an outlier

  /// Whitened errors of one observation besides the anchor's.
  struct Errors {
    Vec<S, 2> pixel;
    S depth;  ///< zero where none was measured
  };

  static S square(S x) { return x * x; }
  static S anchor_depth_error(const Landmark& landmark) {
    const InverseDepth<S>& depth = landmark.observations[landmark.anchor].depth;
    return (landmark.inverse_range / landmark.bearing.z() - depth.value) / depth.sigma;
  }
  static Errors errors_of(const PointObservation<S>& seen, const Projection<S>& projection, S inverse_depth) {
    Errors out;
    const S u = projection.uv[0] - S(seen.uv[0]), v = projection.uv[1] - S(seen.uv[1]);
    for (int k = 0; k < 2; ++k) out.pixel[k] = S(seen.L(k, 0)) * u + S(seen.L(k, 1)) * v;
    out.depth = seen.depth.valid ? (inverse_depth - seen.depth.value) / seen.depth.sigma : S(0);
    return out;
  }
  double cost_of(const Errors& errors) const {
    return double(pixel_loss_.rho(errors.pixel.squaredNorm()) + depth_loss_.rho(square(errors.depth))) / 2;
  }

  /// All rows of one landmark, whitened and weighted. Returns their cost.
  double add_rows(const Sensors& rig, const Landmark& landmark, const Window& window, const Views& views,
                  Elimination& rows) const {
    rows.reset(landmark.anchor);
    double cost = 0;
    for (int slot = 0; slot < slots; ++slot) {
      if (!landmark.observations[slot].valid || !window[slot].used) continue;
      cost += slot == landmark.anchor ? add_anchor(landmark, rows) : add_view(rig, landmark, slot, views, rows);
    }
    return cost;
  }

  /// The row of the depth measured in the anchor.
  double add_anchor(const Landmark& landmark, Elimination& rows) const {
    const InverseDepth<S>& depth = landmark.observations[landmark.anchor].depth;
    if (!depth.valid) return 0;
    const S r = anchor_depth_error(landmark), w = std::sqrt(depth_loss_.weight(r * r));
    rows.template add<1>(Mat<S, 1, 1>(w / (depth.sigma * landmark.bearing.z())), Vec<S, 1>(w * r));
    return double(depth_loss_.rho(r * r)) / 2;
  }

  /// Weighted rows of one observation by P~ and by lambda: two of the pixel, one of the depth where there is one, and
  /// zeros that make them four.
  struct ViewRows {
    bool valid, depth;
    double cost;
    S pixel_chi2;
    Vec<S, 3> P;  ///< P~
    Mat<S, 4, 3> J_r_P;
    Vec<S, 4> J_r_lambda, r;
  };

  ViewRows linearize_view(const Sensors& rig, const Landmark& landmark, int slot, const Views& views) const {
    const PointObservation<S>& seen = landmark.observations[slot];
    const RelativeView<S>& view = views(landmark.anchor, slot);
    const S lambda = landmark.inverse_range;
    ViewRows out;
    out.P = view.scaled_point(landmark.bearing, lambda);
    const Projection<S> projection = rig.vision.camera.project(out.P);
    out.valid = projection.valid;
    out.pixel_chi2 = std::numeric_limits<S>::infinity();
    out.cost = invalid_cost;
    if (!out.valid) return out;
    const S iz = S(1) / out.P.z();
    const Errors errors = errors_of(seen, projection, lambda * iz);
    out.pixel_chi2 = errors.pixel.squaredNorm();
    out.cost = cost_of(errors);
    const S w = std::sqrt(pixel_loss_.weight(out.pixel_chi2));
    for (int k = 0; k < 2; ++k) {
      const S wL0 = w * S(seen.L(k, 0)), wL1 = w * S(seen.L(k, 1));
      for (int c = 0; c < 3; ++c) {
        out.J_r_P(k, c) = wL0 * projection.J_uv_p(0, c) + wL1 * projection.J_uv_p(1, c);
        out.J_r_P(2 + k, c) = S(0);
      }
      out.r[k] = w * errors.pixel[k];
      out.r[2 + k] = S(0);
    }
    const S w_z = std::sqrt(depth_loss_.weight(square(errors.depth)));
    out.depth = Sensors::has_depth && seen.depth.valid && iz > S(0);
    if (out.depth) {
      out.J_r_P(2, 2) = -w_z / seen.depth.sigma * lambda * iz * iz;  // of lambda / P~_z
      out.r(2) = w_z * errors.depth;
    }
    out.J_r_lambda.noalias() = out.J_r_P * view.t_target_anchor();
    if (out.depth) out.J_r_lambda(2) += w_z / seen.depth.sigma * iz;
    return out;
  }

  /// The rows of the observation in `slot`, another keyframe than the anchor.
  double add_view(const Sensors& rig, const Landmark& landmark, int slot, const Views& views, Elimination& rows) const {
    const ViewRows lin = linearize_view(rig, landmark, slot, views);
    if (!lin.valid) return lin.cost;
    const Mat<S, 4, 6> J =
        views(landmark.anchor, slot).template target_jacobian<4>(lin.J_r_P, lin.P, landmark.inverse_range);
    lin.depth ? add_top<3>(slot, J, lin, rows) : add_top<2>(slot, J, lin, rows);
    return lin.cost;
  }
  template <int R>
  static void add_top(int slot, const Mat<S, 4, 6>& J, const ViewRows& lin, Elimination& rows) {
    Mat<S, R, 6> J_top;
    Vec<S, R> J_lambda, r;
    for (int k = 0; k < R; ++k) {
      for (int c = 0; c < 6; ++c) J_top(k, c) = J(k, c);
      J_lambda[k] = lin.J_r_lambda[k];
      r[k] = lin.r[k];
    }
    rows.template add<R>(slot, J_top, J_lambda, r);
  }

  Huber<S> pixel_loss_{S(2.45)};  ///< sqrt(chi2_95_2dof)
  Huber<S> depth_loss_{S(1.345)};
  std::array<Elimination, Map::Landmarks::capacity()> eliminations_;
  std::array<S, Map::Landmarks::capacity()> steps_, backup_;
};

}  // namespace plumbline
