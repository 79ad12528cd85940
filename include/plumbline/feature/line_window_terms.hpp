#pragma once
/// What the lines add to a window's cost: their rows, eliminated one landmark at a time.
///                                                                         docs/math/window.md, docs/math/line.md
///   cost = 1/2 sum rho(|L r_endpoints|^2) + 1/2 sum rho(|L_z r_inverse_depths|^2)
/// over all keyframes, the anchor included. In a step a landmark is held by sigma = 1 on each of its four angles   (31)
/// against what its views leave open: one plane holds all of them, or the line is far. That is damping and moves no
/// minimum; it never goes into a prior. A landmark whose distance stays unknown after the step is dropped.

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/line_landmark.hpp"
#include "plumbline/mapping/window_views.hpp"
#include "plumbline/residual/anchored_line.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <SensorRig Sensors, class Map, int BlockDim>
class LineWindowTerms {
 public:
  using S = typename Sensors::Scalar;
  using Window = typename Map::Window;
  using Landmark = typename Map::Landmark;
  using Views = WindowViews<S, Window::slots>;
  static constexpr int slots = Window::slots;
  static constexpr int rows_per_view = Sensors::has_depth ? 4 : 2;
  static constexpr int max_rows = rows_per_view * slots + 4;
  using Elimination = LandmarkElimination<S, 4, BlockDim, slots, max_rows>;
  using Pairs = typename Elimination::Pairs;

  /// True when a landmark takes part: located and seen by a keyframe besides its anchor.
  static bool takes_part(const Landmark& landmark) {
    return landmark.located && landmark.seen_by_anchor().valid && landmark.observation_count() >= 2;
  }

  /// Linearizes all landmarks at the current state, adds their rows to `pairs` and returns their cost.
  double linearize(const Sensors&, const Map& map, const Window& window, const Views& views, Pairs& pairs) {
    double cost = 0;
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      eliminations_[i].reset();
      if (!takes_part(landmark)) continue;
      cost += add_rows(landmark, window, views, eliminations_[i]);
      eliminations_[i].template add<4>(Mat<S, 4, 4>::Identity(), Vec<S, 4>::Zero());  // (31)
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
      steps_[i].setZero();
      if (eliminations_[i].rows() == 0) continue;
      steps_[i] = eliminations_[i].back_substitute(d, Sensors::state_dim);
      predicted += eliminations_[i].predicted_decrease(steps_[i]);
    }
    return predicted;
  }

  /// Makes those steps; `restore` takes them back.
  void step(Map& map) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      Landmark& landmark = map.landmarks()[i];
      backup_[i] = landmark.line;
      if (takes_part(landmark)) landmark.line = landmark.line.plus(steps_[i]);
    }
  }
  void restore(Map& map) const {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) map.landmarks()[i].line = backup_[i];
  }

  /// The cost alone, at the current state.
  double cost(const Sensors&, const Map& map, const Window& window, const Views& views) const {
    double sum = 0;
    for (const Landmark& landmark : map.landmarks()) {
      if (!takes_part(landmark)) continue;
      const Plucker<S> line = landmark.line.plucker();
      for (int slot = 0; slot < slots; ++slot) {
        const SegmentObservation<S>& seen = landmark.observations[slot];
        if (!seen.valid || !window[slot].used) continue;
        const Errors errors = errors_of(seen, in_camera(landmark.anchor, slot, views, line));
        sum += errors.valid ? cost_of(errors) : invalid_cost;
      }
    }
    return sum;
  }

  /// After convergence: observations that do not belong, the landmarks' covariances given the poses, and landmarks that
  /// came to nothing.
  void finish(const Sensors&, Map& map, const Window& window, const Views& views) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      Landmark& landmark = map.landmarks()[i];
      if (!takes_part(landmark)) continue;
      drop_outliers(landmark, views);
      add_rows(landmark, window, views, eliminations_[i]);
      eliminations_[i].template add<4>(Mat<S, 4, 4>::Identity(), Vec<S, 4>::Zero());  // (31)
      const bool known = eliminations_[i].covariance(landmark.covariance);
      if (!known || !landmark.is_sound()) landmark.located = landmark.current.valid = false;
    }
  }

  /// Gives `take` what would be lost with the keyframe in `slot`, landmark by landmark: all rows of those anchored in
  /// it; of the others, which stay, the rows of their observation there and of the anchor's pixels, with a line of its
  /// own. That forgets how the observation refined the landmark, but not how it ties the two keyframes together. The
  /// anchor's depth stays with the landmark: it must not count twice. Residuals are those of the current state.
  void for_each_leaving(int slot, const Sensors&, const Map& map, const Window& window, const Views& views,
                        auto&& take) {
    for (std::size_t i = 0; i < map.landmarks().size(); ++i) {
      const Landmark& landmark = map.landmarks()[i];
      if (!takes_part(landmark)) continue;
      if (landmark.anchor == slot) {
        add_rows(landmark, window, views, eliminations_[i]);
      } else {
        if (!landmark.observations[slot].valid) continue;
        const LineInAnchor line(landmark.line);
        eliminations_[i].reset(landmark.anchor);
        const SegmentObservation<S>& seen = landmark.seen_by_anchor();
        const Vec<S, 2> r = seen.pixels_L * seen.pixels.residual(line.plucker);
        add_measurement(landmark, line, landmark.anchor, views, seen.pixels, seen.pixels_L, r, eliminations_[i]);
        add_view(landmark, line, slot, views, eliminations_[i]);
      }
      if (eliminations_[i].rows() > 0) take(std::as_const(eliminations_[i]));
    }
  }

 private:
  static constexpr double invalid_cost = 100;  ///< of an observation that the current state cannot explain at all
  static constexpr S drop_chi2 = S(25);        ///< whitened squared error beyond which an observation is an outlier

  /// Whitened errors of one observation.
  struct Errors {
    bool valid;
    Vec<S, 2> pixels;
    Vec<S, 2> depth;  ///< zero where none was measured
  };

  static Plucker<S> in_camera(int anchor, int slot, const Views& views, const Plucker<S>& line) {
    return slot == anchor ? line : line_in_target(views(anchor, slot), line);
  }
  static Errors errors_of(const SegmentObservation<S>& seen, const Plucker<S>& line) {
    Errors out{line_visible<S>(line, seen.pixels.bearing_start + seen.pixels.bearing_end), Vec<S, 2>::Zero(),
               Vec<S, 2>::Zero()};
    if (!out.valid) return out;
    out.pixels = seen.pixels_L * seen.pixels.residual(line);
    if (seen.has_depth) out.depth = seen.depth_L * seen.depth.residual(line);
    return out;
  }
  double cost_of(const Errors& errors) const {
    return (loss_.rho(errors.pixels.squaredNorm()) + loss_.rho(errors.depth.squaredNorm())) / 2;
  }

  /// What all observations of a landmark share.
  using LineInAnchor = LinearizedLine<S>;

  /// All rows of one landmark, whitened and weighted. Returns their cost.
  double add_rows(const Landmark& landmark, const Window& window, const Views& views, Elimination& rows) const {
    const LineInAnchor line(landmark.line);
    rows.reset(landmark.anchor);
    double cost = 0;
    for (int slot = 0; slot < slots; ++slot) {
      if (landmark.observations[slot].valid && window[slot].used) cost += add_view(landmark, line, slot, views, rows);
    }
    return cost;
  }

  /// The rows of the observation in `slot`.
  double add_view(const Landmark& landmark, const LineInAnchor& line, int slot, const Views& views,
                  Elimination& rows) const {
    const SegmentObservation<S>& seen = landmark.observations[slot];
    const Errors errors = errors_of(seen, in_camera(landmark.anchor, slot, views, line.plucker));
    if (!errors.valid) return invalid_cost;
    if (!add_measurement(landmark, line, slot, views, seen.pixels, seen.pixels_L, errors.pixels, rows)) {
      return invalid_cost;
    }
    if (seen.has_depth) add_measurement(landmark, line, slot, views, seen.depth, seen.depth_L, errors.depth, rows);
    return cost_of(errors);
  }

  template <class Measurement>
  bool add_measurement(const Landmark& landmark, const LineInAnchor& line, int slot, const Views& views,
                       const Measurement& measurement, const Mat<S, 2, 2>& L, const Vec<S, 2>& r,
                       Elimination& rows) const {
    const AnchoredLine<Measurement> residual{measurement};
    const S w = std::sqrt(loss_.weight(r.squaredNorm()));
    const Mat<S, 2, 2> wL = w * L;
    const Vec<S, 2> weighted = w * r;
    if (slot == landmark.anchor) {
      const auto lin = residual.linearize_in_anchor(line);
      if (!lin.valid) return false;
      return rows.template add<2>(Mat<S, 2, 4>(wL * lin.J_r_line), weighted);
    }
    const auto lin = residual.linearize_in_target(views(landmark.anchor, slot), line);
    if (!lin.valid) return false;
    return rows.template add<2>(slot, Mat<S, 2, 6>(wL * lin.J_r_target), Mat<S, 2, 4>(wL * lin.J_r_line), weighted);
  }

  /// The anchor's own pixels stay: without them nothing tells where on the line it was seen.
  void drop_outliers(Landmark& landmark, const Views& views) const {
    const Plucker<S> line = landmark.line.plucker();
    for (int slot = 0; slot < slots; ++slot) {
      SegmentObservation<S>& seen = landmark.observations[slot];
      if (!seen.valid) continue;
      const Errors errors = errors_of(seen, in_camera(landmark.anchor, slot, views, line));
      if (slot != landmark.anchor) seen.valid = errors.valid && errors.pixels.squaredNorm() < drop_chi2;
      seen.has_depth = seen.has_depth && errors.depth.squaredNorm() < drop_chi2;
    }
  }

  Huber<S> loss_{S(2.45)};  ///< sqrt(chi2_95_2dof)
  std::array<Elimination, Map::Landmarks::capacity()> eliminations_;
  std::array<Vec<S, 4>, Map::Landmarks::capacity()> steps_;
  std::array<Line3<S>, Map::Landmarks::capacity()> backup_;
};

}  // namespace plumbline
