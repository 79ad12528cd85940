#pragma once
/// Start of a camera without depth: a first view, and a second one from far enough aside.  docs/math/geometry.md
///
/// Where a gyroscope knows the rotation it is the first guess, and the translation follows from it; else a homography
/// or an essential matrix, whichever the pairs speak for, and nothing while they are ambiguous.

#include <cstddef>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/relative_pose.hpp"
#include "plumbline/geometry/two_view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/start/start_report.hpp"

namespace plumbline {

struct TwoViewStartOptions {
  double min_parallax_rad = 0.035;  ///< of the two first views
  double min_inliers = 0.7;         ///< of the pairs, that fit the two views
  double max_start_s = 4;           ///< longer without a second view: begin with a new first one
};

/// The rotation between the views is known to some degrees.
template <class S, std::size_t Capacity>
class GuidedTwoView {
 public:
  struct Options : TwoViewStartOptions {
    int min_pairs = 20;
    TwoViewOptions two_view;
  };

  TwoView<S, Capacity> solve(const FixedVector<BearingPair<S>, Capacity>& pairs, const SO3<S>& R_2_1,
                             const Options& options) {
    return solver_.solve(pairs, R_2_1, options.two_view);
  }

 private:
  TwoViewSolver<S, Capacity> solver_;
};

/// Nothing is known of how the views stand to each other.
template <class S, std::size_t Capacity>
class UnguidedTwoView {
 public:
  struct Options : TwoViewStartOptions {
    int min_pairs = 30;
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
class TwoViewStart {
 public:
  static constexpr bool needs_second_view = true;
  static constexpr std::size_t max_pairs = 512;
  using Options = typename Solver<S, max_pairs>::Options;

  explicit TwoViewStart(const Options& options) : options_(options) {}

  TwoViewStart& visual() { return *this; }

  /// What both views see, anew in each frame.
  void clear_pairs() { pairs_.clear(); }
  void add_pair(const Vec<S, 3>& f1, const Vec<S, 3>& f2) {
    if (!pairs_.full()) pairs_.push_back({f1, f2});
  }
  int pairs() const { return static_cast<int>(pairs_.size()); }

  /// Too little is left of the first view, or it was too long ago: take another one.
  bool has_expired(double age_s) const { return pairs() < options_.min_pairs || age_s > options_.max_start_s; }

  /// Whether the second view is found; `report` says what is missing.
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

  /// The second camera in coordinates of the first. The unit of length: the distance between the two views is a fifth
  /// of it, so that most points are some units away.
  SE3<S> T_1_2() const {
    const SE3<S> T_1_2 = T_2_1_.inverse();
    return SE3<S>(T_1_2.rotation(), Vec<S, 3>(S(0.2) * T_1_2.p()));
  }

 private:
  Options options_;
  FixedVector<BearingPair<S>, max_pairs> pairs_;
  [[no_unique_address]] Solver<S, max_pairs> solver_;
  SE3<S> T_2_1_;
};

}  // namespace plumbline
