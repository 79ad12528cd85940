#pragma once
/// Backend: Levenberg-Marquardt over a window of K frames and the landmarks that they observe, with marginalization of
/// the frames that leave and first-estimate Jacobians.                                              docs/math/window.md
///
/// `optimize` minimizes  |r0 + J0 e|^2 / 2 + the factors of propagation and frames + the terms of all features  over
/// the states of the frames; landmarks are eliminated one by one. `retire` turns a frame, and the landmarks anchored in
/// it, into the next prior (r0, J0). State and factors of a frame are those of the propagation: poses and no factors
/// without an IMU (docs/math/inertial_window.md). Further factors of single frames: docs/math/factors.md.

#include <cmath>
#include <concepts>

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/gauge_prior.hpp"
#include "plumbline/backend/rig_prior.hpp"
#include "plumbline/backend/window_equations.hpp"
#include "plumbline/backend/window_options.hpp"
#include "plumbline/backend/window_prior.hpp"
#include "plumbline/backend/window_problem.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/factor/frame_factors.hpp"
#include "plumbline/feature/landmark_ties.hpp"
#include "plumbline/feature/readout_derivatives.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/map/retired.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/state/time_offset_estimate.hpp"

namespace plumbline {

template <Propagation PropagationT, class LandmarksT, int K, class FrameFactorsT = NoFrameFactors>
class WindowBackend {
 public:
  using Sensors = typename PropagationT::Sensors;
  using S = typename PropagationT::S;
  using Layout = typename PropagationT::Layout;
  using State = typename PropagationT::State;
  using Factor = typename PropagationT::Factor;
  using Factors = typename PropagationT::template Factors<K>;
  using FrameFactors = FrameFactorsT;
  using Landmarks = LandmarksT;
  using Window = FrameWindow<S, Layout, K>;
  using Options = WindowOptions;
  using Normal = typename WindowEquations<Window>::Normal;

  WindowBackend(const Options& options, const typename PropagationT::Options& propagation)
      : options_(options), factors_(propagation), rig_prior_(options.extrinsics, options.time_offset) {}

  const Window& window() const { return window_; }
  Window& window() { return window_; }
  const Factors& factors() const { return factors_; }
  Factors& factors() { return factors_; }
  const FrameFactors& frame_factors() const { return frame_factors_; }

  /// Prior on the readout time of a rolling shutter, value and sigma [s], from the next `start` on.
  void set_readout_prior(double value_s, double sigma_s) { prior_.set_readout_prior(value_s, sigma_s); }
  /// The readout time with which observations were corrected to the middle of their frames [s].
  void set_readout(double value_s) { prior_.set_readout(value_s); }

  /// Clears everything and begins with one frame whose pose defines the world. Returns its slot.
  int start(TimeNs t_ns, const State& x) {
    window_.clear();
    factors_.deactivate();
    frame_factors_.clear();
    is_world_measured_ = false;
    retired_ns_ = t_ns;
    const int slot = insert(t_ns, x, {});
    prior_.set(window_, slot, pose_gauge<Layout>(options_));
    equations_.order(window_);
    equations_.begin();  // defines a covariance before the first optimization
    equations_.add_priors_and_factors(window_, prior_, factors_);
    return slot;
  }

  /// The same frames with new states, `state_of(k)` for the frame in slot k. The prior is on position and heading of
  /// the oldest frame, with `J_prior`, whitened rows on the other blocks of its state. From now on factors are active,
  /// and extrinsics and time offset are estimated (the offset unless it is fixed). Factors of frames were measured in
  /// another world: they are removed.
  template <int Rows>
  void restart(auto&& state_of, const Mat<double, Rows, Layout::dim>& J_prior, const SE3<S>& T_body_cam,
               const TimeOffsetEstimate& time_offset = {}) {
    for (int k = 0; k < K; ++k) {
      if (window_[k].used) window_.state(k) = typename Window::State(state_of(k));
    }
    frame_factors_.clear();
    is_world_measured_ = false;
    factors_.reintegrate(window_);
    factors_.initialize_velocities(window_);
    factors_.activate();
    const int oldest = window_.oldest();
    prior_.set(window_, oldest, heading_gauge<Layout>(options_, window_.T_world_body(oldest).R(), J_prior));
    rig_prior_.begin(window_, T_body_cam, time_offset);
  }

  /// Adds a measured distance between two frames to the prior, with its sigma [m].
  void hold_distance(int i, int j, double distance, double sigma) {
    prior_.add_distance(window_, i, j, distance, sigma);
  }
  /// Fixes the unit of length by the present distance between two frames: it is not observable without depth and IMU.
  ///                                                                                            docs/math/window.md (5)
  void hold_scale(int i, int j) {
    const double distance = double(norm(window_.T_world_body(j).p() - window_.T_world_body(i).p()));
    hold_distance(i, j, distance, options_.sigma_first_scale * distance);
  }

  /// Inserts a frame with its factor to an earlier one; returns its slot. The window must not be full.
  int insert(TimeNs t_ns, const State& x, const Factor& factor) {
    const int slot = window_.insert(t_ns, x);
    factors_.insert(slot, x, factor);
    return slot;
  }

  /// Attaches a factor to the frame in `slot`, for the next solution and as long as the frame is in the window. False,
  /// and nothing attached, when it is not valid at the state of the frame or there is no room.
  template <class G>
  bool add_factor(int slot, const G& factor) requires FrameFactorsT::template takes<G> {
    const auto& state = window_[slot].state;
    const bool added = window_[slot].used && factor.linearize(state.value(), state.first_estimate()).valid &&
                       frame_factors_.insert(slot, factor);
    is_world_measured_ |= added;
    return added;
  }

  /// Removes a frame that is no anchor and that no prior refers to, without leaving information.
  void drop(Landmarks& landmarks, int slot) {
    landmarks.for_each([&](auto& store) { store.remove_frame(slot); });
    factors_.remove(slot);
    frame_factors_.remove(slot);
    window_.remove(slot);
  }

  /// Solves for frames and landmarks; with fewer iterations when the newest frame is no keyframe.
  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                                     bool keyframe = true) {
    LevenbergMarquardtOptions solver = options_.solver;
    if (!keyframe) solver.max_iterations = options_.frame_iterations;
    return optimize(rig, T_body_cam, landmarks, solver);
  }
  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                                     const LevenbergMarquardtOptions& solver) {
    if (factors_.active()) factors_.reintegrate(window_);
    const int oldest = window_.oldest();
    const SE3<S> T_oldest = window_.T_world_body(oldest);
    equations_.order(window_);
    rig_prior_.update_hold(window_);
    Problem problem{*this, rig, landmarks, T_body_cam};
    views_.update(window_, T_body_cam);
    ties_.choose(landmarks, views_);
    const LevenbergMarquardtSummary summary = levenberg_marquardt(problem, solver);
    ties_.finish(landmarks, views_);
    if (summary.accepted > 0 && !is_world_measured_) {
      hold_world(oldest, T_oldest);
      views_.update(window_, T_body_cam);
    }
    // Linearized once more for the covariance: at the solution, and without the damping of landmarks.
    begin_linearization();
    landmarks.for_each_with(
        terms_, [&](auto& store, auto& terms) { terms.finish(rig, store, window_, views_, equations_.pairs); });
    ties_.choose(landmarks, views_);
    ties_.linearize(landmarks, views_);
    problem.eliminate(solver.mu_min);
    return summary;
  }

  /// After `optimize`, with a rolling shutter: correction of the readout time with its sigma, frames and landmarks
  /// being estimated with it; false when it is not observable.                         docs/math/rolling_shutter.md (4)
  bool find_readout(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                    ReadoutCorrection& out) requires Sensors::rolls {
    const typename Normal::Vector b = equations_.normal.b();
    Problem problem{*this, rig, landmarks, T_body_cam};
    ReadoutBorder border;
    typename Normal::Vector column, x;
    if (!problem.border_by_readout(options_.solver.mu_min, column, border)) return false;
    if (!equations_.normal.solve(0, column, x)) return false;
    const double information = border.information + column.dot(x), gradient = border.gradient + b.dot(x);
    if (!(information > 0) || !std::isfinite(gradient)) return false;
    out = {-gradient / information, 1 / std::sqrt(information)};
    return true;
  }

  /// The frame in `slot`, as it is handed to a map.
  Retired<State, Landmarks> retired(int slot, const Landmarks& landmarks) const {
    return {slot, window_, landmarks, {this, [](const void* window, int i, int j, auto& covariance) {
                                         const auto& self = *static_cast<const WindowBackend*>(window);
                                         return self.equations_.relative_covariance(self.window_, i, j, covariance);
                                       }}};
  }
  /// Marginalizes the frame in `slot`, all landmarks anchored in it and its observations of others into the prior on
  /// the frames that stay, and hands frame and landmarks to the map.
  void retire(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, int slot, auto& map) {
    map.on_retired(retired(slot, landmarks));
    views_.update(window_, T_body_cam);
    begin_linearization();
    prior_.begin_retirement(window_);
    factors_.for_each_row(window_, slot, [&](const auto&... row) { prior_.add_factor(row...); });
    factors_.remove(slot);
    frame_factors_.for_each_marginalized_row(window_, slot, [&](const auto&... row) { prior_.add_factor(row...); });
    frame_factors_.remove(slot);
    landmarks.for_each_with(terms_, [&](auto& store, auto& terms) {
      terms.for_each_leaving(slot, rig, store, window_, views_, [&](const auto& landmark, const auto& derivatives) {
        prior_.add_landmark(landmark, equations_.pairs, derivatives);
      });
      store.remove_frame(slot);
    });
    const double left_s = seconds_between(retired_ns_, window_[slot].t_ns);
    retired_ns_ = window_[slot].t_ns;
    prior_.retire(window_, slot, options_.readout_walk * std::sqrt(std::abs(left_s)));
  }

  /// Marginal covariance of the leading blocks of the newest frame, its pose first; false when it is not defined.
  template <int Dim>
  bool covariance_of_newest(Mat<S, Dim, Dim>& covariance) const {
    return equations_.covariance(window_.newest(), covariance);
  }
  /// Covariance of the extrinsics [rad, m], right increments; false when they are not estimated.
  bool covariance_of_extrinsics(Mat<double, 6, 6>& covariance) const requires has_extrinsics<Layout> {
    return window_.estimates_extrinsics() && equations_.covariance(equations_.rig, covariance);
  }
  /// Standard deviation of the time offset [s]; false when it is not estimated.
  bool sigma_of_time_offset(double& sigma_s) const requires has_time_offset<Layout> {
    return window_.estimates_time_offset() && equations_.sigma_of_time_offset(sigma_s);
  }

 private:
  using Problem = WindowProblem<WindowBackend>;
  friend Problem;
  template <class Store>
  using Terms = WindowTerms<Store>;
  using AllTerms = typename Landmarks::template TupleOf<Terms>;

  /// Cost without the landmarks.
  double cost_of_frames() const {
    double cost = prior_.cost(window_) + factors_.cost(window_) + rig_prior_.cost(window_);
    if constexpr (!std::same_as<FrameFactors, NoFrameFactors>) cost += frame_factors_.cost(window_);
    return cost;
  }

  /// Moves the window as a whole, so that the frame in `slot` has the pose that it had, with velocities its position.
  ///                                                                                            docs/math/window.md (7)
  void hold_world(int slot, const SE3<S>& T_before) {
    const SE3<S>& T = window_.T_world_body(slot);
    SO3<S> R;
    if constexpr (!Layout::template has<state::Velocity>) R = T_before.rotation() * T.rotation().inverse();
    window_.transform(SE3<S>(R, T_before.p() - R * T.p()));
  }
  void begin_linearization() {
    equations_.pairs.reset();
    views_.set_transports(window_, equations_.pairs);
  }

  Options options_;
  Window window_, backup_;
  [[no_unique_address]] Factors factors_;
  [[no_unique_address]] FrameFactors frame_factors_;
  WindowViews<S, K> views_;
  WindowPriorOf<Window, AllTerms> prior_;
  [[no_unique_address]] RigPrior<Layout> rig_prior_;
  WindowEquations<Window> equations_;
  AllTerms terms_;
  bool is_world_measured_ = false;  ///< by a factor of a frame since the start
  TimeNs retired_ns_ = 0;           ///< time stamp of the frame that was retired last
  [[no_unique_address]] LandmarkTies<Landmarks> ties_;
};

}  // namespace plumbline
