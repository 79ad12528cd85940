#pragma once
/// What the points add to a window's cost: their rows, eliminated one landmark at a time.   docs/math/window.md
///
///   cost = 1/2 sum rho(|r_uv|^2 / sigma_px^2) + 1/2 sum rho(r_z^2 / sigma_z^2)
/// over reprojections in every keyframe but the anchor and inverse depths measured in every keyframe, anchor included.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/point_landmark.hpp"
#include "plumbline/mapping/window_views.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
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
  static constexpr S lambda_min = S(1e-3), lambda_max = S(20);  ///< inverse range stays in this interval [1/m]

  /// True when a landmark takes part: located and seen by a keyframe besides its anchor.
  static bool takes_part(const Landmark& landmark) { return landmark.located && landmark.observation_count() >= 2; }

  /// Linearizes all landmarks at the current state and returns their cost.
  double linearize(const Sensors& rig, const Map& map, const Window& window, const Views& views) {
    double cost = 0;
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      if (takes_part(landmark)) cost += rows_of(rig, landmark, window, views, eliminations_[i]).cost;
    }
    return cost;
  }

  /// Eliminates all landmarks with damping `mu` and adds what is left of them to the normal equations.
  template <class Equations>
  bool eliminate(const Map& map, S mu, Equations& equations) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      if (!takes_part(map.landmarks()[i])) continue;
      if (!eliminations_[i].eliminate(mu)) return false;
      eliminations_[i].add_to(equations);
    }
    return true;
  }

  /// The landmarks' steps that belong to the poses' step d; returns what they add to the predicted decrease.
  template <class Vector>
  double solve(const Map& map, const Vector& d) {
    double predicted = 0;
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      steps_[i] = S(0);
      if (!takes_part(map.landmarks()[i])) continue;
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
          if (seen.depth.valid) sum += depth_loss_.rho(square(anchor_depth_error(landmark) / seen.depth.sigma)) / 2;
          continue;
        }
        const Vec<S, 3> p = views.current(landmark.anchor, slot).scaled_point(landmark.bearing, landmark.inverse_range);
        const Projection<S> projection = rig.vision.camera.project(p);
        if (!projection.valid) {
          sum += invalid_cost;
          continue;
        }
        sum += pixel_loss_.rho(whitened(seen, projection.uv).squaredNorm()) / 2;
        if (seen.depth.valid) {
          sum += depth_loss_.rho(square((landmark.inverse_range / p.z() - seen.depth.value) / seen.depth.sigma)) / 2;
        }
      }
    }
    return sum;
  }

  /// After convergence: the landmarks' standard deviations given the poses, and observations that do not belong.
  void finish(const Sensors& rig, Map& map, const Window& window, const Views& views) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      Landmark& landmark = map.landmarks()[i];
      if (!takes_part(landmark)) continue;
      drop_outliers(rig, landmark, views);
      const S information = rows_of(rig, landmark, window, views, eliminations_[i]).information;
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
        rows_of(rig, landmark, window, views, eliminations_[i]);
      } else {
        eliminations_[i].reset();
        if (landmark.observations[slot].valid) add_view(rig, landmark, slot, views, eliminations_[i]);
      }
      if (eliminations_[i].rows() > 0) take(std::as_const(eliminations_[i]));
    }
  }

 private:
  static constexpr double invalid_cost = 100;  ///< of an observation that the current state cannot explain at all
  static constexpr S drop_chi2 = S(25);        ///< whitened squared error beyond which an observation is an outlier

  struct RowsSummary {
    double cost = 0;
    S information = S(0);  ///< of the inverse range, given the poses

    RowsSummary& operator+=(const RowsSummary& other) {
      cost += other.cost;
      information += other.information;
      return *this;
    }
  };

  static S square(S x) { return x * x; }
  static Vec<S, 2> whitened(const PointObservation<S>& seen, const Vec<S, 2>& uv) {
    return seen.L.template cast<S>() * (uv - seen.uv.template cast<S>());
  }
  static S anchor_depth_error(const Landmark& landmark) {
    return landmark.inverse_range / landmark.bearing.z() - landmark.observations[landmark.anchor].depth.value;
  }

  /// All rows of one landmark, whitened and weighted.
  RowsSummary rows_of(const Sensors& rig, const Landmark& landmark, const Window& window, const Views& views,
                      Elimination& rows) const {
    rows.reset();
    RowsSummary sum;
    for (int slot = 0; slot < slots; ++slot) {
      if (!landmark.observations[slot].valid || !window[slot].used) continue;
      sum += slot == landmark.anchor ? add_anchor(landmark, rows) : add_view(rig, landmark, slot, views, rows);
    }
    return sum;
  }

  /// The row of the depth measured in the anchor.
  RowsSummary add_anchor(const Landmark& landmark, Elimination& rows) const {
    const InverseDepth<S>& depth = landmark.observations[landmark.anchor].depth;
    if (!depth.valid) return {};
    const S r = anchor_depth_error(landmark) / depth.sigma;
    const S w = std::sqrt(depth_loss_.weight(r * r));
    const S J = w / (depth.sigma * landmark.bearing.z());
    rows.template add<1>(Mat<S, 1, 1>(J), Vec<S, 1>(w * r));
    return {depth_loss_.rho(r * r) / 2, J * J};
  }

  /// The rows of the observation in `slot`, another keyframe than the anchor.
  RowsSummary add_view(const Sensors& rig, const Landmark& landmark, int slot, const Views& views,
                       Elimination& rows) const {
    const int anchor = landmark.anchor;
    const S lambda = landmark.inverse_range;
    const PointObservation<S>& seen = landmark.observations[slot];
    const RelativeView<S>& view = views.current(anchor, slot);
    const Mat<S, 6, 6>& transport = views.transport(anchor, slot);
    const InverseDepthReprojection<typename Sensors::Camera> reprojection{seen.uv.template cast<S>()};
    auto pixel = reprojection.linearize(rig.vision.camera, view, landmark.bearing, lambda);
    if (!pixel.valid) return {invalid_cost, S(0)};
    const Mat<S, 2, 2> L = seen.L.template cast<S>();
    pixel.r = L * pixel.r;
    pixel.J_r_target = L * pixel.J_r_target;
    pixel.J_r_anchor = pixel.J_r_target * transport;
    pixel.J_r_lambda = L * pixel.J_r_lambda;
    const S s = pixel.r.squaredNorm();
    const S w = std::sqrt(pixel_loss_.weight(s));
    RowsSummary sum{pixel_loss_.rho(s) / 2, square(w) * pixel.J_r_lambda.squaredNorm()};
    add(rows, anchor, slot, pixel, w);
    if (!seen.depth.valid) return sum;
    auto depth = InverseDepthMeasurement<S>{seen.depth.value}.linearize(view, landmark.bearing, lambda);
    if (!depth.valid) return sum;
    depth.J_r_anchor = depth.J_r_target * transport;
    const S s_z = square(depth.r(0) / seen.depth.sigma);
    const S w_z = std::sqrt(depth_loss_.weight(s_z)) / seen.depth.sigma;
    sum += {depth_loss_.rho(s_z) / 2, square(w_z * depth.J_r_lambda(0))};
    add(rows, anchor, slot, depth, w_z);
    return sum;
  }

  template <int Rows>
  static void add(Elimination& rows, int anchor, int slot, const AnchoredLinearization<S, Rows>& lin, S w) {
    rows.template add<Rows>(anchor, Mat<S, Rows, 6>(w * lin.J_r_anchor), slot, Mat<S, Rows, 6>(w * lin.J_r_target),
                            Mat<S, Rows, 1>(w * lin.J_r_lambda), Vec<S, Rows>(w * lin.r));
  }

  void drop_outliers(const Sensors& rig, Landmark& landmark, const Views& views) const {
    for (int slot = 0; slot < slots; ++slot) {
      PointObservation<S>& seen = landmark.observations[slot];
      if (!seen.valid || slot == landmark.anchor) continue;
      const Vec<S, 3> p = views.current(landmark.anchor, slot).scaled_point(landmark.bearing, landmark.inverse_range);
      const Projection<S> projection = rig.vision.camera.project(p);
      if (!(projection.valid && whitened(seen, projection.uv).squaredNorm() < drop_chi2)) seen.valid = false;
    }
  }

  Huber<S> pixel_loss_{S(2.45)};  ///< sqrt(chi2_95_2dof)
  Huber<S> depth_loss_{S(1.345)};
  std::array<Elimination, Map::Landmarks::capacity()> eliminations_;
  std::array<S, Map::Landmarks::capacity()> steps_, backup_;
};

}  // namespace plumbline
