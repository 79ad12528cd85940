#pragma once
/// Two-view initializer of a camera without depth: relative pose and map from a first view and a second one with enough
/// parallax.                                                                         docs/math/geometry.md
///
/// With a gyroscope its rotation is the initial value, and the translation follows from it. Without one, homography and
/// essential matrix are compared; there is no result while the choice is ambiguous.

#include <cstddef>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/relative_pose.hpp"
#include "plumbline/geometry/two_view.hpp"
#include "plumbline/initialization/init_report.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

struct TwoViewInitializerOptions {
  double min_parallax_rad = 0.035;  ///< smallest parallax of the two views [rad]; tuned: docs/decisions/132 (chosen)
  /// Smallest fraction of the pairs that fit, in front of both views; tuned: docs/decisions/132 (chosen).
  double min_inliers = 0.7;
  /// Age of a first view after which it is replaced [s]; tuned: docs/decisions/132 (chosen).
  double max_wait_s = 4;
};

/// Solver for views whose relative rotation is known to some degrees.
template <class S, std::size_t Capacity>
class GuidedTwoView {
 public:
  struct Options : TwoViewInitializerOptions {
    int min_pairs = 20;  ///< smallest number of pairs; tuned: docs/decisions/132 (chosen)
    TwoViewOptions two_view;
  };

  TwoView<S, Capacity> solve(const FixedVector<BearingPair<S>, Capacity>& pairs, const SO3<S>& R_2_1,
                             const Options& options) {
    return solver_.solve(pairs, R_2_1, options.two_view);
  }

 private:
  TwoViewSolver<S, Capacity> solver_;
};

/// Solver for views of unknown relative pose.
template <class S, std::size_t Capacity>
class UnguidedTwoView {
 public:
  struct Options : TwoViewInitializerOptions {
    int min_pairs = 30;  ///< smallest number of pairs; tuned: docs/decisions/132 (chosen)
    RelativePoseOptions two_view;
  };

  TwoView<S, Capacity> solve(const FixedVector<BearingPair<S>, Capacity>& pairs, const SO3<S>& R_2_1,
                             const Options& options) const {
    auto found =
        RelativePoseSolver<S, Capacity>().solve(std::span(pairs.data(), pairs.size()), R_2_1, options.two_view);
    found.two_view.valid = found.valid;
    return found.two_view;
  }
};

template <class S, template <class, std::size_t> class Solver>
class TwoViewInitializer {
 public:
  static constexpr bool needs_second_view = true;
  static constexpr std::size_t max_pairs = 512;
  using Options = typename Solver<S, max_pairs>::Options;

  explicit TwoViewInitializer(const Options& options) : options_(options) {}

  TwoViewInitializer& visual() { return *this; }

  /// Removes all feature pairs; they are added again for each frame.
  void clear_pairs() { pairs_.clear(); }
  void add_pair(const Vec<S, 3>& f1, const Vec<S, 3>& f2) {
    if (!pairs_.full()) pairs_.push_back({f1, f2});
  }
  int pairs() const { return static_cast<int>(pairs_.size()); }

  /// Whether the first view is to be replaced: too few pairs are left, or it is too old.
  bool has_expired(double age_s) const { return pairs() < options_.min_pairs || age_s > options_.max_wait_s; }

  /// Estimates the relative pose. True when the second view is accepted; `report` gets the figures.
  bool solve(const SO3<S>& R_2_1, InitReport& report) {
    const TwoView<S, max_pairs> found = solver_.solve(pairs_, R_2_1, options_);
    report.parallax_rad = double(found.parallax);
    report.inliers = double(found.inliers) / double(pairs_.size());
    if (!found.valid || !(report.parallax_rad > options_.min_parallax_rad)) return false;
    if (!(double(found.in_front) > options_.min_inliers * double(pairs_.size()))) {
      report.stage = InitStage::two_views_disagree;
      return false;
    }
    T_2_1_ = found.T_2_1;
    return true;
  }

  /// The second camera in coordinates of the first, at that distance. Where it is not known (0), the unit of length is
  /// five times the distance of the two views, so that most points are at a distance of some units.
  SE3<S> T_1_2(S distance = S(0)) const {
    constexpr S as_unit = S(0.2);  // numerics: inverse ranges of about one
    if (!(distance > S(0))) distance = as_unit;
    const SE3<S> T_1_2 = T_2_1_.inverse();
    return SE3<S>(T_1_2.rotation(), Vec<S, 3>(distance * T_1_2.p()));
  }

 private:
  Options options_;
  FixedVector<BearingPair<S>, max_pairs> pairs_;
  [[no_unique_address]] Solver<S, max_pairs> solver_;
  SE3<S> T_2_1_;
};

}  // namespace plumbline
