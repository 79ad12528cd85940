#pragma once
/// Bundle adjustment of some keyframes, the points and the lines that they observe, in slices of bounded work.
///                                                                              docs/math/local_bundle_adjustment.md
///   solver.add_keyframe(...); solver.add_point(...); solver.add_observation(...); ...
///   solver.begin();
///   while (!solver.iterate(budget)) {}          // one call a frame: the result does not depend on the budget
///   solver.pose(k), solver.point(p), solver.is_inlier(o)
/// Levenberg-Marquardt (docs/math/solver.md (14), (15)) with points eliminated one by one, then lines; odometry counts
/// as least squares, all else with Huber's kernel. Poses, points and bearings are S; products and the cost are double.
/// What is not finite, or names what there is not, is refused. The state is always that of the lowest cost so far.
/// Scale and position in the map come from fixed keyframes or edges; what nothing determines is held by the damping
/// alone.

#include <cmath>
#include <concepts>
#include <cstdint>

#include "plumbline/map/bundle_cost.hpp"
#include "plumbline/map/bundle_edges.hpp"
#include "plumbline/map/bundle_keyframes.hpp"
#include "plumbline/map/bundle_lines.hpp"
#include "plumbline/map/bundle_members.hpp"
#include "plumbline/map/bundle_points.hpp"
#include "plumbline/map/local_bundle_adjustment_options.hpp"
#include "plumbline/solver/levenberg_marquardt_steps.hpp"
#include "plumbline/solver/normal_equations.hpp"

namespace plumbline {

template <std::floating_point S, int MaxKeyframes, int MaxPoints, int MaxObservations, int MaxLines, int MaxEdges>
class LocalBundleAdjustment {
 public:
  explicit LocalBundleAdjustment(const LocalBundleAdjustmentOptions& options = {})
      : options_(options), losses_{{S(std::sqrt(options.chi2_two_rows))}, {S(std::sqrt(options.chi2_range))}} {}

  void clear() {
    keyframes_.clear();
    points_.clear();
    lines_.clear();
    edges_.clear();
    phase_ = Phase::done;
    steps_ = {};
  }
  /// Index, or -1: full, or not finite. A fixed keyframe never moves.
  int add_keyframe(const SE3<S>& T_map_cam, bool is_fixed) { return keyframes_.add(T_map_cam, is_fixed); }
  /// Index, or -1: full, or not finite.
  int add_point(const Vec<S, 3>& p_map) {
    const int p = points_.add(p_map);
    if (p != none) members_.reset(p);
    return p;
  }
  /// A unit bearing in the camera; `range` from the camera's center, 0 where it was not measured. Index, or -1: full,
  /// no such keyframe or point, not a unit vector, no positive sigma, not finite.
  int add_observation(int keyframe, int point, const Vec<S, 3>& bearing, S sigma_rad, S range = S(0),
                      S sigma_range = S(0)) {
    const bool has_range = range > S(0) && sigma_range > S(0);
    const bool is_good = is_unit(bearing) && sigma_rad > S(0) && (has_range || range == S(0));
    if (!keyframes_.has(keyframe) || !is_good) return none;
    return points_.observe(keyframe, point, BearingObservation<S>(bearing, sigma_rad, range, sigma_range));
  }
  /// A line through a point, in the map. Index, or -1: full, no direction, not finite.
  int add_line(const Vec<S, 3>& point_map, const Vec<S, 3>& direction_map) {
    return lines_.add(point_map, direction_map);
  }
  /// The point lies on the line: its distance to it by the range from the camera of the point's first observation has
  /// this sigma [rad]. A point is on one line. False: no such line or point, observed by no keyframe, on a line
  /// already.
  bool add_to_line(int line, int point, S sigma) {
    if (!points_.has(point) || points_.first_keyframe(point) == none) return false;
    return members_.add(line, point, sigma, points_.first_keyframe(point), keyframes_, lines_);
  }
  /// A segment by the unit bearings of its ends, which are anywhere along the line. Index, or -1 as for observations;
  /// also where both bearings are one.
  int add_line_observation(int keyframe, int line, const Vec<S, 3>& bearing_a, const Vec<S, 3>& bearing_b,
                           S sigma_rad) {
    if (!keyframes_.has(keyframe) || !is_unit(bearing_a) || !is_unit(bearing_b) || !(sigma_rad > S(0))) return none;
    if (!(norm(bearing_a.cross(bearing_b)) > S(1e-6))) return none;
    return lines_.add_segment(keyframe, line, bearing_a, bearing_b, sigma_rad, keyframes_);
  }
  /// The pose of camera b in camera a, as odometry measured it, with the covariance of its right increment [rad, m].
  bool add_edge(int a, int b, const SE3<S>& T_a_b, const Mat<S, 6, 6>& covariance) {
    return keyframes_.has(a) && keyframes_.has(b) && edges_.add(a, b, T_a_b, covariance);
  }

  /// Sorts what was added and evaluates the start. An observation that is not valid there (a point behind the camera)
  /// does not count. Nothing may be added before it is done; then begin() may be called again and goes on at the state.
  void begin() {
    keyframes_.begin();
    points_.begin(keyframes_);
    lines_.begin(keyframes_);
    for (int p = 0; p < points_.count(); ++p) members_.begin(p, points_.state(p), keyframes_, lines_);
    double cost = 0;
    for (int p = 0; p < points_.count(); ++p) cost += point_cost(p, false).cost;
    for (int l = 0; l < lines_.count(); ++l) cost += lines_.cost(l, false, keyframes_, losses_).cost;
    for (int e = 0; e < edges_.count(); ++e) cost += edges_.state_cost(e, keyframes_);
    steps_.begin(options_.levenberg_marquardt, cost);
    next_system();
  }

  /// Works until about `budget` units are spent; a unit is an observation's work. True when it is done. The work on one
  /// point is not divided, nor is the linear system of the poses: about keyframes^2 units.
  bool iterate(int budget) {
    while (phase_ != Phase::done && budget > 0) budget -= advance();
    return phase_ == Phase::done;
  }

  bool has_converged() const {
    return phase_ == Phase::done && steps_.summary().termination == LevenbergMarquardtEnd::converged;
  }
  /// Complete when done.
  const LevenbergMarquardtSummary& summary() const { return steps_.summary(); }
  S initial_cost() const { return S(summary().initial_cost); }
  S cost() const { return S(summary().final_cost); }
  const SE3<S>& pose(int keyframe) const { return keyframes_.state(keyframe).T_map_cam; }
  const Vec<S, 3>& point(int point) const { return points_.state(point); }
  /// A point of the line, next to the camera that observed it first, and its unit direction.
  Vec<S, 3> line_point(int line) const { return lines_.point(line); }
  Vec<S, 3> line_direction(int line) const { return lines_.direction(line); }
  /// In front of the camera, and both of bearing and range within their quantiles.
  bool is_inlier(int observation) const {
    const auto errors = points_.errors(observation, keyframes_);
    return errors.valid && errors.bearing <= S(options_.chi2_two_rows) && errors.range <= S(options_.chi2_range);
  }

 private:
  static constexpr int none = -1;
  using Keyframes = BundleKeyframes<S, MaxKeyframes>;
  using Points = BundlePoints<S, MaxKeyframes, MaxPoints, MaxObservations>;
  using Normal = NormalEquations<double, 6, MaxKeyframes>;
  enum class Phase : std::uint8_t { lines, points, line_systems, poses, try_lines, try_points, done };

  static bool is_unit(const Vec<S, 3>& v) { return std::abs(squared_norm(v) - S(1)) < S(1e-3); }

  int advance() {
    switch (phase_) {
      case Phase::lines: return index_ < lines_.count() ? linearize_line() : start(Phase::points);
      case Phase::points: return index_ < points_.count() ? eliminate_point() : start(Phase::line_systems);
      case Phase::line_systems: return index_ < lines_.count() ? eliminate_line() : start(Phase::poses);
      case Phase::poses: return solve();
      case Phase::try_lines: return index_ < lines_.count() ? try_line() : start(Phase::try_points);
      case Phase::try_points: return index_ < points_.count() ? try_point() : evaluated();
      case Phase::done: break;
    }
    return 1;
  }
  int start(Phase phase) {
    phase_ = phase;
    index_ = 0;
    return 1;
  }
  void next_system() {
    sums_.reset(keyframes_.free());
    trial_cost_ = predicted_ = 0;
    start(steps_.done() ? Phase::done : Phase::lines);
  }

  int linearize_line() {
    const int l = index_++;
    lines_.linearize(l, keyframes_, losses_, sums_);
    return 1 + lines_.segments_of(l);
  }
  int eliminate_point() {
    const int p = index_++;
    const bool is_member = members_.has(p);
    system_.reset();
    points_.linearize(p, keyframes_, losses_, system_, sums_);
    if (is_member) members_.add_rows(p, points_.state(p), keyframes_, losses_, system_, lines_, sums_);
    if (!system_.eliminate(steps_.mu(), points_.factor(p), sums_)) {
      failed();
    } else if (is_member) {
      members_.take_over(p, system_, points_.factor(p), lines_);
    }
    return 1 + points_.observations_of(p);
  }
  int eliminate_line() {
    if (!lines_.eliminate(index_++, steps_.mu(), sums_)) failed();
    return 1 + keyframes_.free();
  }
  int solve() {
    normal_.reset(keyframes_.free());
    sums_.add_to(normal_);
    for (int e = 0; e < edges_.count(); ++e) edges_.linearize(e, keyframes_, normal_);
    if (normal_.solve(steps_.mu(), d_)) {
      predicted_ = normal_.predicted_decrease(steps_.mu(), d_);
      keyframes_.make_trial(d_);
      start(Phase::try_lines);
    } else {
      failed();
    }
    return 1 + edges_.count() + keyframes_.free() * keyframes_.free();
  }
  int try_line() {
    const int l = index_++;
    predicted_ += lines_.solve(l, keyframes_);
    trial_cost_ += cost_of_valid_step([&](double share) {
      lines_.make_trial(l, share);
      return lines_.cost(l, true, keyframes_, losses_);
    });
    return 1 + lines_.segments_of(l);
  }
  int try_point() {
    const int p = index_++;
    Vec<double, 3> W_d = points_.by_poses(p, keyframes_);
    if (members_.has(p)) W_d += members_.by_line_and_pose(p, keyframes_, lines_);
    const Vec<double, 3> d = points_.factor(p).step(W_d);
    predicted_ += points_.factor(p).predicted_decrease(d);
    trial_cost_ += cost_of_valid_step([&](double share) {
      points_.make_trial(p, Vec<double, 3>(share * d));
      return point_cost(p, true);
    });
    return 1 + points_.observations_of(p);
  }
  /// Of its observations, and of its distance to its line.
  BundleCost point_cost(int p, bool is_trial) const {
    BundleCost out = points_.cost(p, is_trial, keyframes_, losses_);
    const Vec<S, 3>& p_map = is_trial ? points_.trial(p) : points_.state(p);
    if (members_.has(p)) out.cost += members_.cost(p, p_map, is_trial, keyframes_, losses_, lines_);
    return out;
  }
  int evaluated() {
    for (int e = 0; e < edges_.count(); ++e) trial_cost_ += edges_.trial_cost(e, keyframes_);
    if (steps_.solved(true, predicted_) && steps_.evaluated(trial_cost_)) {
      keyframes_.accept();
      points_.accept();
      lines_.accept();
    }
    next_system();
    return 1 + edges_.count();
  }
  void failed() {
    steps_.solved(false, 0);
    next_system();
  }

  LocalBundleAdjustmentOptions options_;
  BundleLosses<S> losses_;
  LevenbergMarquardtSteps steps_;
  Phase phase_ = Phase::done;
  int index_ = 0;
  double trial_cost_ = 0, predicted_ = 0;
  Keyframes keyframes_;
  Points points_;
  BundleLines<S, MaxKeyframes, MaxLines> lines_;
  BundleMembers<S, MaxKeyframes, MaxPoints, MaxLines> members_;
  BundleEdges<S, MaxKeyframes, MaxEdges> edges_;
  typename Points::System system_;
  typename Points::Sums sums_;
  Normal normal_;
  typename Normal::Vector d_;
};

}  // namespace plumbline
