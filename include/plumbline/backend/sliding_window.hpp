#pragma once
/// Backend: Levenberg-Marquardt over a window of K frames and the landmarks they see, with marginalization of the
/// frames that leave and first-estimate Jacobians.                                          docs/math/window.md
///
/// One call of `optimize` minimizes  |r0 + J0 e|^2 / 2 + the links of the motion model + the terms of all features
/// over the states of the frames; landmarks are eliminated one by one. `retire` turns a frame, and the landmarks
/// anchored in it, into the next (r0, J0). What a frame's state is, and which links hold, is the motion model's: a
/// camera alone has poses and no links, docs/math/inertial_window.md has both.

#include <cmath>

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/rig_prior.hpp"
#include "plumbline/backend/window_equations.hpp"
#include "plumbline/backend/window_prior.hpp"
#include "plumbline/backend/window_problem.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/landmark_ties.hpp"
#include "plumbline/feature/readout_slopes.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/frontend/flow.hpp"
#include "plumbline/map/retired.hpp"
#include "plumbline/motion/motion_model.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"
#include "plumbline/state/clock_belief.hpp"
#include "plumbline/state/frame_window.hpp"

namespace plumbline {

struct WindowOptions {
  LevenbergMarquardtOptions solver;
  int frame_iterations = 4;            ///< for a frame that is no keyframe
  double sigma_first_rotation = 1e-3;  ///< prior on the first pose, which is the world's origin [rad]
  double sigma_first_position = 1e-3;  ///< [m]
  double sigma_first_scale = 1e-3;     ///< of the distance of the first two keyframes where it is the unit, relative
  ExtrinsicsOptions extrinsics;        ///< of the camera on a body with an IMU
  TimeOffsetOptions time_offset;       ///< of its clock
  double readout_walk = 1e-3;  ///< of the shutter's readout time, for what a frame's motion is wrong by [s/sqrt(s)]
};

template <MotionModel Motion, class LandmarksT, int K>
class WindowBackend {
 public:
  using Sensors = typename Motion::Sensors;
  using S = typename Motion::S;
  using Layout = typename Motion::Layout;
  using State = typename Motion::State;
  using Link = typename Motion::Link;
  using Links = typename Motion::template Links<K>;
  using Landmarks = LandmarksT;
  using Window = FrameWindow<S, Layout, K>;
  using Options = WindowOptions;
  using Normal = typename WindowEquations<Window>::Normal;

  WindowBackend(const Options& options, const typename Motion::Options& motion)
      : options_(options), links_(motion), known_(options.extrinsics, options.time_offset) {}

  const Window& window() const { return window_; }
  Window& window() { return window_; }
  const Links& links() const { return links_; }
  Links& links() { return links_; }

  /// What is known of the readout time of a shutter that rolls, from the next `start` on.
  void believe_readout(double value_s, double sigma_s) { prior_.believe_readout(value_s, sigma_s); }
  /// The readout time that observations have been brought to the middle of their frames with.
  void set_readout(double value_s) { prior_.set_readout(value_s); }

  /// Forgets everything and begins with one frame at a pose that defines the world. Returns its slot.
  int start(TimeNs t_ns, const State& x) {
    window_.clear();
    links_.deactivate();
    left_ns_ = t_ns;
    const int slot = insert(t_ns, x, {});
    Mat<double, state::Pose::dim, state::Pose::dim> J = zeros<double, state::Pose::dim, state::Pose::dim>();
    for (int k = 0; k < state::Pose::dim; ++k) {
      J(k, k) = 1 / (k < 3 ? options_.sigma_first_rotation : options_.sigma_first_position);
    }
    set_prior(slot, J);
    equations_.order(window_);
    equations_.begin();  // so that a covariance is defined before the first optimization
    equations_.add_known(window_, prior_, links_);
    return slot;
  }

  /// The same frames as if they had just begun, frame k with the state `state_of(k)`: no prior but position and heading
  /// of the oldest one and `J_rest`, rows on the rest of its state. From now on their links take part, and the rig is
  /// estimated: where the camera sits, and how its clock goes unless it is known.
  template <int Rows>
  void restart(auto&& state_of, const Mat<double, Rows, Layout::dim>& J_rest, const SE3<S>& T_body_cam,
               const ClockBelief& clock = {}) {
    for (int k = 0; k < K; ++k) {
      if (window_[k].used) window_.state(k) = typename Window::State(state_of(k));
    }
    links_.follow_biases(window_);
    links_.guess_velocities(window_);
    links_.activate();
    const int oldest = window_.oldest();
    const Mat<S, 3, 3> R = window_.T_world_body(oldest).R();
    constexpr int position = 3, place_rows = 4;  // of the pose's increment
    Mat<double, place_rows + Rows, Layout::dim> J;
    set_zero(J);
    for (int k = 0; k < 3; ++k) {
      J(k, position + k) = 1 / options_.sigma_first_position;
      J(3, k) = double(R(2, k)) / options_.sigma_first_rotation;  // heading: the vertical part of R dphi
    }
    for (int k = 0; k < Rows; ++k) {
      for (int c = 0; c < Layout::dim; ++c) J(place_rows + k, c) = J_rest(k, c);
    }
    set_prior(oldest, J);
    known_.begin(window_, T_body_cam, clock);
  }

  /// The distance between two frames, with a sigma [m].
  void hold_distance(int i, int j, double distance, double sigma) {
    prior_.add_distance(window_, i, j, distance, sigma);
  }
  /// From now on the distance between two frames defines the unit of length: without depth or an IMU nothing else does.
  void hold_scale(int i, int j) {
    const double distance = double(norm(window_.T_world_body(j).p() - window_.T_world_body(i).p()));
    hold_distance(i, j, distance, options_.sigma_first_scale * distance);
  }

  /// A frame with its link to an earlier one. The window must not be full.
  int insert(TimeNs t_ns, const State& x, const Link& link) {
    const int slot = window_.insert(t_ns, x);
    links_.insert(slot, x, link);
    return slot;
  }

  /// Frees the slot of a frame that no landmark is anchored in and no prior knows, without a trace.
  void drop(Landmarks& landmarks, int slot) {
    landmarks.for_each([&](auto& store) { store.remove_frame(slot); });
    links_.remove(slot);
    window_.remove(slot);
  }

  /// After a keyframe, or after a frame that is none and gets fewer iterations.
  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                                     bool keyframe = true) {
    LevenbergMarquardtOptions solver = options_.solver;
    if (!keyframe) solver.max_iterations = options_.frame_iterations;
    return optimize(rig, T_body_cam, landmarks, solver);
  }
  LevenbergMarquardtSummary optimize(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks,
                                     const LevenbergMarquardtOptions& solver) {
    if (links_.active()) links_.follow_biases(window_);
    equations_.order(window_);
    known_.watch(window_);
    Problem problem{*this, rig, landmarks, T_body_cam};
    views_.update(window_, T_body_cam);
    ties_.choose(landmarks, views_);
    const LevenbergMarquardtSummary summary = levenberg_marquardt(problem, solver);
    ties_.finish(landmarks, views_);
    // For the covariance: here, not a step before, and what damped the landmarks is no knowledge.
    begin_linearization();
    landmarks.for_each_with(
        terms_, [&](auto& store, auto& terms) { terms.finish(rig, store, window_, views_, equations_.pairs); });
    ties_.choose(landmarks, views_);
    ties_.linearize(landmarks, views_);
    problem.eliminate(solver.mu_min);
    return summary;
  }

  /// After `optimize`, of a shutter that rolls: by how much the readout time is wrong by all that the window knows,
  /// frames and landmarks being estimated with it; false when it does not say.        docs/math/rolling_shutter.md (4)
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

  /// Turns the frame in `slot`, all landmarks anchored in it and its observations of others into prior information on
  /// the frames that stay, and hands them to the map.
  void retire(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, int slot, auto& map) {
    map.retire(Retired<State, Landmarks>(slot, window_[slot], landmarks));
    views_.update(window_, T_body_cam);
    begin_linearization();
    prior_.begin_retirement(window_);
    links_.for_each_row(window_, slot, [&](const auto&... row) { prior_.add_link(row...); });
    links_.remove(slot);
    landmarks.for_each_with(terms_, [&](auto& store, auto& terms) {
      terms.for_each_leaving(slot, rig, store, window_, views_, [&](const auto& landmark, const auto& slopes) {
        prior_.add_landmark(landmark, equations_.pairs, slopes);
      });
      store.remove_frame(slot);
    });
    const double left_s = seconds_between(left_ns_, window_[slot].t_ns);
    left_ns_ = window_[slot].t_ns;
    prior_.retire(window_, slot, options_.readout_walk * std::sqrt(std::abs(left_s)));
  }

  /// Covariance of the leading blocks of the newest frame, its pose first, given the whole window; false when it is not
  /// defined.
  template <int Dim>
  bool covariance_of_newest(Mat<S, Dim, Dim>& covariance) const {
    return equations_.covariance(window_.newest(), covariance);
  }
  /// Of where the camera sits, right increments; false when it is not estimated.
  bool covariance_of_extrinsics(Mat<double, 6, 6>& covariance) const requires has_extrinsics<Layout> {
    return window_.estimates_extrinsics() && equations_.covariance(equations_.rig, covariance);
  }
  /// Of its clock's offset [s]; false when it is not estimated.
  bool sigma_of_time_offset(double& sigma_s) const requires has_time_offset<Layout> {
    return window_.estimates_time_offset() && equations_.sigma_of_time_offset(sigma_s);
  }

 private:
  using Problem = WindowProblem<WindowBackend>;
  friend Problem;
  template <class Store>
  using Terms = WindowTerms<Store>;
  using AllTerms = typename Landmarks::template TupleOf<Terms>;

  double cost_of_frames() const { return prior_.cost(window_) + links_.cost(window_) + known_.cost(window_); }

  void begin_linearization() {
    equations_.pairs.reset();
    views_.set_transports(window_, equations_.pairs);
  }

  /// A prior on one frame alone.
  template <int Rows, int Columns>
  void set_prior(int slot, const Mat<double, Rows, Columns>& J) {
    Mat<double, Rows, Layout::dim> widened;
    set_zero(widened);
    for (int c = 0; c < Columns; ++c) {
      for (int k = 0; k < Rows; ++k) widened(k, c) = J(k, c);
    }
    prior_.set(window_, slot, widened);
  }

  Options options_;
  Window window_, backup_;
  [[no_unique_address]] Links links_;
  WindowViews<S, K> views_;
  WindowPriorOf<Window, AllTerms> prior_;
  [[no_unique_address]] RigPrior<Layout> known_;
  WindowEquations<Window> equations_;
  AllTerms terms_;
  TimeNs left_ns_ = 0;  ///< of the frame that left last
  [[no_unique_address]] LandmarkTies<Landmarks> ties_;
};

/// K frames; FrontEndPolicy finds their landmarks.
template <int K, class FrontEndPolicy = Flow>
struct SlidingWindow {
  static_assert(K >= 3, "plumbline: a window needs at least three keyframes");
  static constexpr int slots = K;
  using FrontEnds = FrontEndPolicy;

  template <MotionModel Motion, class Landmarks>
  using Backend = WindowBackend<Motion, Landmarks, K>;
};

}  // namespace plumbline
