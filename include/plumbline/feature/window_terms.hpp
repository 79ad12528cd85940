#pragma once
/// Terms of a window: rows of the landmarks of one kind by poses and landmarks, eliminated one landmark at a time.
///                                                                                          docs/math/window.md
/// A kind may add rows on the increment of a landmark (`add_damping`) against unobservable directions. They do not
/// change the minimum and are never part of a prior.

#include <array>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/solver/anchored_products.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

template <class Store>
class WindowTerms {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Landmark = typename Store::Landmark;
  static constexpr int slots = Store::slots;
  using Views = WindowViews<S, slots>;
  static constexpr int max_rows = Kind::rows_per_view * slots + Kind::damping_rows;
  using Elimination = LandmarkElimination<S, Kind::dim, state::Pose::dim, slots, max_rows>;
  using Pairs = typename Elimination::Pairs;
  using Derivatives = std::conditional_t<Sensors::rolls, ReadoutDerivatives<S, max_rows>, NoReadoutDerivatives>;
  using Products = AnchoredProducts<double, state::Pose::dim, slots>;

  /// Linearizes all landmarks at the current state, adds their rows to `pairs` and returns their cost.
  double linearize(const Sensors& rig, const Store& store, const auto& window, const Views& views, Pairs& pairs) {
    double cost = 0;
    for_each(store, [&](const Landmark& landmark, Elimination& rows) {
      rows.reset();
      if (!landmark.takes_part()) return;
      cost += add_rows(rig, landmark, window, views, rows);
      Kind::add_damping(rows);
      rows.add_to(pairs);
    });
    return cost;
  }

  /// Eliminates the landmarks of one anchor with damping `mu`; `products` is to be subtracted from the normal
  /// equations, which contain the full products of their rows from `pairs`. False when a landmark is singular.
  bool eliminate(const Store& store, S mu, int anchor, Products& products) {
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      Elimination& landmark = eliminations_[i];
      if (landmark.rows() == 0 || landmark.anchor() != anchor) continue;
      if (!landmark.eliminate(mu)) return false;
      landmark.add_to(products);
    }
    return true;
  }
  /// The same for all anchors, for a single kind.
  template <class Equations>
  bool eliminate(const Store& store, S mu, const Pairs& pairs, Equations& equations) {
    Products products;
    for (int anchor = 0; anchor < slots; ++anchor) {
      products.reset();
      if (!eliminate(store, mu, anchor, products)) return false;
      products.subtract_from(equations, anchor, pairs);
    }
    return true;
  }

  /// Computes the steps of the landmarks from the step d of the frames, with blocks of `stride` numbers; returns their
  /// part of the predicted decrease.
  template <class Vector>
  double solve(const Store& store, const Pairs& pairs, const Vector& d, int stride) {
    double predicted = 0;
    set_zero(steps_);
    for (int anchor = 0; anchor < slots; ++anchor) {
      auto relative_steps = pairs.steps(anchor, d, stride);
      for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
        const Elimination& landmark = eliminations_[i];
        if (landmark.rows() == 0 || landmark.anchor() != anchor) continue;
        steps_[i] = landmark.is_complete() ? landmark.back_substitute(d, stride)
                                           : landmark.back_substitute_relative(relative_steps);
        predicted += landmark.predicted_decrease(steps_[i]);
      }
    }
    return predicted;
  }

  // For constraints between landmarks (feature/collinear_terms.hpp).

  Elimination& elimination(int index) { return eliminations_[static_cast<std::size_t>(index)]; }
  const Vec<S, Kind::dim>& step_of(int index) const { return steps_[static_cast<std::size_t>(index)]; }
  /// Computes the step of a landmark again, with the contribution `by_other` of another landmark's step; returns the
  /// change of the predicted decrease.
  template <class Vector>
  double solve_again(int index, const Vector& d, int stride, const Vec<double, Kind::dim>& by_other) {
    const Elimination& landmark = elimination(index);
    Vec<S, Kind::dim>& step = steps_[static_cast<std::size_t>(index)];
    const double before = landmark.predicted_decrease(step);
    step = landmark.back_substitute(d, stride, by_other);
    return landmark.predicted_decrease(step) - before;
  }

  /// Applies the steps; `restore` undoes them.
  void step(Store& store) {
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      Landmark& landmark = store.landmarks()[i];
      backup_[i] = landmark.geometry;
      if (landmark.takes_part()) Kind::step(landmark.geometry, steps_[i]);
    }
  }
  void restore(Store& store) const {
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) store.landmarks()[i].geometry = backup_[i];
  }

  /// The cost alone, at the current state.
  double cost(const Sensors& rig, const Store& store, const auto& window, const Views& views) const {
    double sum = 0;
    for (const Landmark& landmark : store.landmarks()) {
      if (!landmark.takes_part()) continue;
      const typename Kind::InAnchor in_anchor(landmark.geometry);
      for (int slot = 0; slot < slots; ++slot) {
        const auto& seen = landmark.observations[slot];
        if (!seen.valid || !window[slot].used) continue;
        sum += slot == landmark.anchor ? Kind::cost_in_anchor(in_anchor, seen)
                                       : Kind::cost(rig, in_anchor, seen, views(landmark.anchor, slot));
      }
    }
    return sum;
  }

  /// After convergence: rejects outlier observations, discards landmarks that are not determined, and sets the
  /// covariance of the others, the frames fixed. Linearizes the rest and adds its rows to `pairs`.
  void finish(const Sensors& rig, Store& store, const auto& window, const Views& views, Pairs& pairs) {
    for_each(store, [&](Landmark& landmark, Elimination& rows) {
      rows.reset();
      landmark.solved = false;
      if (!landmark.takes_part()) return;
      const typename Kind::InAnchor in_anchor(landmark.geometry);
      for (int slot = 0; slot < slots; ++slot) {
        auto& seen = landmark.observations[slot];
        if (!seen.valid || !window[slot].used) continue;
        if (slot == landmark.anchor) {
          Kind::reject_outliers_in_anchor(in_anchor, seen);
        } else {
          Kind::reject_outliers(rig, in_anchor, seen, views(landmark.anchor, slot));
        }
      }
      add_rows(rig, landmark, window, views, rows);
      Kind::add_damping(rows);
      Mat<S, Kind::dim, Kind::dim> covariance;
      const bool known = rows.covariance(covariance);
      if (!Kind::set_covariance(landmark.geometry, landmark.seen_by_anchor(), known ? &covariance : nullptr)) {
        landmark.located = landmark.current.valid = false;
      }
      landmark.solved = landmark.takes_part();
      if (landmark.solved) {
        rows.add_to(pairs);
      } else {
        rows.reset();
      }
    });
  }

  /// After `finish` and an elimination: replaces the residuals of all rows by their derivatives by the readout time, so
  /// that another elimination gives the column of the readout time.                    docs/math/rolling_shutter.md (4)
  void exchange_residuals(const Sensors& rig, const Store& store, const auto& window, const Views& views, Pairs& pairs,
                          ReadoutBorder& border) {
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      Elimination& rows = eliminations_[i];
      if (rows.rows() == 0) continue;
      Derivatives derivatives;
      add_views(rig, store.landmarks()[i], window, views, derivatives);
      gradients_[i] = rows.eliminated();
      for (int k = 0; k < rows.rows(); ++k) {
        const S derivative = std::isfinite(derivatives[k]) ? derivatives[k] : S(0);  // no information
        border.information += double(derivative) * double(derivative);
        border.gradient += double(derivative) * double(rows.residual(k));
        rows.set_residual(k, derivative);
      }
      rows.add_to(pairs);
    }
  }
  /// After that elimination: subtracts the part of the eliminated landmarks.
  void subtract_eliminated(const Store& store, ReadoutBorder& border) const {
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      const Elimination& rows = eliminations_[i];
      if (rows.rows() == 0) continue;
      border.information -= squared_norm(rows.eliminated());
      border.gradient -= dot(rows.eliminated(), gradients_[i]);
    }
  }

  /// take(rows, derivatives) for each landmark with rows that are lost when the frame in `slot` is marginalized: all
  /// rows of landmarks anchored in it; of other landmarks, which remain, the rows of the observation by this frame,
  /// with a copy of the landmark as their unknown. The information on the landmark itself is lost, that between the two
  /// frames is kept. Residuals are those of the current state. Landmarks located since the last solution are skipped:
  /// their observations were not checked for outliers.
  void for_each_leaving(int slot, const Sensors& rig, const Store& store, const auto& window, const Views& views,
                        auto&& take) {
    for_each(store, [&](const Landmark& landmark, Elimination& rows) {
      if (!landmark.solved || !landmark.takes_part()) return;
      rows.reset(landmark.anchor);
      add_leaving(slot, rig, landmark, window, views, rows);
      if (rows.rows() == 0) return;
      Derivatives derivatives;
      if constexpr (Sensors::rolls) add_leaving(slot, rig, landmark, window, views, derivatives);
      take(std::as_const(rows), std::as_const(derivatives));
    });
  }

 private:
  void for_each(auto& store, auto&& visit) {
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) visit(store.landmarks()[i], eliminations_[i]);
  }

  /// Adds all rows of one landmark, whitened and weighted; returns their cost.
  double add_rows(const Sensors& rig, const Landmark& landmark, const auto& window, const Views& views,
                  Elimination& rows) const {
    rows.reset(landmark.anchor);
    return add_views(rig, landmark, window, views, rows);
  }
  /// The same for empty `rows`, of either type: rows or derivatives.
  static double add_views(const Sensors& rig, const Landmark& landmark, const auto& window, const Views& views,
                          auto& rows) {
    const typename Kind::Linearized linearized(landmark.geometry);
    double cost = 0;
    for (int slot = 0; slot < slots; ++slot) {
      const auto& seen = landmark.observations[slot];
      if (!seen.valid || !window[slot].used) continue;
      cost += slot == landmark.anchor ? Kind::add_anchor(linearized, seen, rows)
                                      : Kind::add_view(rig, linearized, seen, views(landmark.anchor, slot), slot, rows);
    }
    return cost;
  }
  /// Adds the rows that are lost with the frame in `slot`, or their derivatives.
  static void add_leaving(int slot, const Sensors& rig, const Landmark& landmark, const auto& window,
                          const Views& views, auto& rows) {
    if (landmark.anchor == slot) {
      add_views(rig, landmark, window, views, rows);
      return;
    }
    const auto& seen = landmark.observations[slot];
    if (!seen.valid) return;
    const typename Kind::Linearized linearized(landmark.geometry);
    Kind::add_anchor_pixels(linearized, landmark.seen_by_anchor(), rows);
    Kind::add_view(rig, linearized, seen, views(landmark.anchor, slot), slot, rows);
  }

  std::array<Elimination, Store::capacity> eliminations_;
  std::array<Vec<S, Kind::dim>, Store::capacity> steps_;
  std::array<typename Kind::Geometry, Store::capacity> backup_;
  using Gradients = std::array<Vec<double, Kind::dim>, Store::capacity>;
  [[no_unique_address]] std::conditional_t<Sensors::rolls, Gradients, std::tuple<>> gradients_;
};

}  // namespace plumbline
