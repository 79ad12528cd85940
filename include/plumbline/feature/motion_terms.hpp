#pragma once
/// What the landmarks of one kind say about the pose of one frame, their map being given.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/whitened_rows.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

template <class Store>
class MotionTerms {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::Scalar;
  using Equations = DenseNormalEquations<S, state::Pose::dim>;

  /// All located landmarks that the latest frame sees.
  void collect(const Store& store, const auto& window, const SE3<S>& T_body_cam) {
    items_.clear();
    for (std::size_t i = 0; i < store.landmarks().size(); ++i) {
      const auto& landmark = store.landmarks()[i];
      if (!landmark.current.valid || !landmark.located) continue;
      items_.push_back({static_cast<int>(i), Kind::in_world(landmark.geometry, landmark.current,
                                                            window.T_world_body(landmark.anchor) * T_body_cam)});
    }
  }

  std::size_t size() const { return items_.size(); }

  /// Adds the weighted rows at a pose.
  void accumulate(const Sensors& rig, const BodyView<S>& view, Equations& system) {
    errors_.clear();
    for (const Item& item : items_) {
      const auto rows = Kind::pixel_rows(rig, view, item.landmark);
      errors_.push_back(rows.valid ? squared_norm(rows.r) : std::numeric_limits<S>::infinity());
      add(rows, Kind::pixel_loss, system);
      if constexpr (Kind::depth_dim > 0) {
        if (Kind::has_depth(item.landmark)) add(Kind::depth_rows(view, item.landmark), Kind::depth_loss, system);
      }
    }
  }

  /// Takes observations that were beyond `chi2` (two degrees of freedom) where they were accumulated last out of the
  /// frame; returns how many stay. The frame's own scale is the median of all errors: blur and rolling shutter make all
  /// of them larger, and then all weigh less.
  int gate(Store& store, S chi2) {
    sorted_ = errors_;
    const std::size_t middle = sorted_.size() / 2;
    std::nth_element(sorted_.begin(), sorted_.begin() + middle, sorted_.end());
    scale2_ = sorted_.empty() ? S(1) : sorted_[middle] / S(1.386);  // median of chi2(2)
    const S scale2 = std::max(S(1), scale2_);
    int inliers = 0;
    for (std::size_t i = 0; i < items_.size(); ++i) {
      if (errors_[i] < chi2 * scale2) {
        ++inliers;
        store.landmarks()[static_cast<std::size_t>(items_[i].index)].current.scale_sigma(std::sqrt(scale2));
      } else {
        store.reject(items_[i].index);
      }
    }
    return inliers;
  }
  /// Errors that were gated last, squared, to those of features that err as they claim to.
  S scale2() const { return scale2_; }

 private:
  struct Item {
    int index;  ///< of the landmark in its store
    typename Kind::InWorld landmark;
  };

  template <int Rows, class Loss>
  static void add(const WhitenedRows<S, Rows>& rows, const Loss& loss, Equations& system) {
    if (!rows.valid) return;
    const S s = squared_norm(rows.r);
    system.add(rows.J, rows.r, loss.weight(s));
    system.add_cost(loss.rho(s));
  }

  FixedVector<Item, Store::capacity> items_;
  FixedVector<S, Store::capacity> errors_, sorted_;  ///< whitened and squared, of the pixels
  S scale2_ = S(1);
};

}  // namespace plumbline
