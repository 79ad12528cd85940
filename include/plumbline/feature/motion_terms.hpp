#pragma once
/// Terms of pose refinement: rows of the landmarks of one kind by the pose of one frame, landmarks fixed.

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

  /// Collects the located landmarks observed by the latest frame.
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

  /// Adds the weighted rows at a pose to `system`.
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

  /// Rejects observations whose squared error at the last `accumulate` exceeded `chi2` (two degrees of freedom) times
  /// the scale of the frame; returns the number of inliers. The scale is the median of all squared errors divided by
  /// 1.386, the median of chi2(2), and at least 1: blur and rolling shutter increase all errors. Inlier sigmas are
  /// multiplied by its square root.
  int gate(Store& store, S chi2) {
    sorted_ = errors_;
    const std::size_t middle = sorted_.size() / 2;
    std::nth_element(sorted_.begin(), sorted_.begin() + middle, sorted_.end());
    constexpr S median_chi2 = S(1.386);  // chi-square quantile 50 %, 2 degrees of freedom
    scale2_ = sorted_.empty() ? S(1) : sorted_[middle] / median_chi2;
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
  /// Ratio of the squared errors to their expectation at the last `gate`, not limited to 1.
  S scale2() const { return scale2_; }

 private:
  struct Item {
    int index;  ///< index of the landmark in its store
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
  FixedVector<S, Store::capacity> errors_, sorted_;  ///< squared whitened errors of the pixels
  S scale2_ = S(1);
};

}  // namespace plumbline
