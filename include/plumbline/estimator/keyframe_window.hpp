#pragma once
/// The window of keyframes and its landmarks: which frames enter, which of them stay, and which leave to the map.
///
/// A frame without IMU factors enters as a keyframe only. A frame with IMU factors always enters, and is solved for
/// with the window; unless it becomes a keyframe it is temporary, and is removed without marginalization when the next
/// comes.

#include <type_traits>
#include <utility>

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/estimator/frame_tracker.hpp"
#include "plumbline/estimator/map_updates.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/shutter_motion.hpp"
#include "plumbline/state/navigation.hpp"
#include "plumbline/state/rig_state.hpp"

namespace plumbline {

template <class Parts, class MapT>
class KeyframeWindow {
 public:
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Propagation = typename Parts::Propagation;
  using State = typename Propagation::State;
  using Landmarks = typename Parts::Landmarks;
  using Backend = typename Parts::Backend;
  using Frames = typename Parts::Window;
  using Tracker = FrameTracker<Parts>;
  using Nav = Navigation<S, typename Propagation::Layout>;
  using Covariance = typename Nav::Covariance;
  static constexpr int none = -1;
  static constexpr double drift_ratio = 3;  ///< of a drifting track to the mean motion; tuned: docs/decisions/011

  KeyframeWindow(const Sensors& rig, const EstimatorOptions<Parts>& options, const auto& map_options)
      : landmarks_(Parts::FrontEnds::make_landmarks(options)),
        backend_(options.backend, options.propagation),
        rule_(options.keyframe),
        min_tracked_(2 * options.pose.min_inliers),
        map_updates_(rig, map_options) {}

  Frames& frames() { return backend_.window(); }
  const Frames& frames() const { return backend_.window(); }
  Landmarks& landmarks() { return landmarks_; }
  const Landmarks& landmarks() const { return landmarks_; }
  Backend& backend() { return backend_; }
  const Backend& backend() const { return backend_; }
  const MapT& map() const { return map_updates_.map(); }
  MapT& map() { return map_updates_.map(); }
  /// Gives the map its time in this frame.
  void work_on_map() { map().work(); }

  /// Slot of the last keyframe.
  int keyframe() const { return keyframe_; }
  /// Whether that is the latest frame.
  bool is_latest_keyframe() const { return is_latest_keyframe_; }
  /// A new frame begins, which is no keyframe so far. Returns the slot of the previous frame, -1 if it is no keyframe.
  int begin_frame() { return std::exchange(is_latest_keyframe_, false) ? keyframe_ : none; }
  S mean_depth() const { return landmarks_.template mean_depth<S>(); }
  /// Mean motion of the landmarks in the image since the last keyframe [px], without those that moved more than three
  /// times the mean: drifting tracks and moving objects.
  double robust_motion_px() const { return landmarks_.motion_since(keyframe_, drift_ratio * motion_px()); }

  bool needs_keyframe(const View<Sensors>& view, Propagation& propagation) {
    const double rad = motion_px() / double(effective_focal_length(view.camera()));
    const bool needed = rule_.is_keyframe(landmarks_.tracked_count(), tracked_at_keyframe_, rad);
    return propagation.confirm_keyframe(
        view.t_ns, [&] { return robust_motion_px(); }, needed);
  }

  /// Removes all landmarks and frames, and inserts the frame as first keyframe at x. Returns its slot.
  int reset(const View<Sensors>& view, const State& x, Tracker& tracker, const RigState<Sensors>& rig_state) {
    map_updates_.reset(backend_, landmarks_, temporary_);
    landmarks_.for_each([](auto& store) { store.clear(); });
    tracker.front_ends().begin_initialization();
    temporary_ = none;
    ReadoutEstimation<Backend>::start(backend_, rig_state);
    const int slot = backend_.start(view.t_ns, x);
    frames().set_latest(slot);
    tracker.front_ends().detect(view, frames(), landmarks_, slot);
    set_zero(keyframe_covariance_);
    is_latest_keyframe_ = false;
    return slot;
  }

  /// Covariance of the latest pose, which is known with the covariance `relative` with respect to the last keyframe.
  Covariance covariance_of(const SE3<S>& T_world_body, const Covariance& relative) const {
    return transported(keyframe_covariance_, frames().T_world_body(keyframe_), T_world_body) + relative;
  }

  /// Moves the navigation state to the latest frame of the window, and reports what limits its pose.
  void accept_latest(Propagation& propagation, Nav& navigation, FrameReport& report) const {
    const State x = frames().latest();
    navigation.move_to(x.T_world_body);
    report.tracked = landmarks_.tracked_count();
    const bool few = report.tracked < min_tracked_;
    report.reason = propagation.diagnose(backend_.factors(), frames(), few);
    report.is_inconsistent = propagation.is_inconsistent();
    if (report.reason == HealthReason::none && few) report.reason = HealthReason::few_features;
    if (propagation.is_initialized()) navigation.set_motion(x);
  }

  /// Inserts the latest frame, which has a pose, as a keyframe.
  void make_keyframe(const View<Sensors>& view, Tracker& tracker, Propagation& propagation,
                     RigState<Sensors>& rig_state, Nav& navigation) {
    const int slot = backend_.insert(view.t_ns, frames().latest(), propagation.factor(keyframe_));
    tracker.detect(view, frames(), landmarks_, slot, rig_state.readout().value_s);
    backend_.optimize(view.rig, view.T_body_cam, landmarks_);
    if (readout_.update(backend_, view, landmarks_, rig_state))
      backend_.optimize(view.rig, view.T_body_cam, landmarks_);
    frames().set_latest(slot);
    adopt_keyframe(view, slot, tracker, propagation, navigation);
    make_room(view);
  }

  /// Inserts a frame with IMU factors in the state x. Returns whether it is to become a keyframe.
  bool insert(const View<Sensors>& view, State x, Propagation& propagation) {
    const bool was_stationary = propagation.is_stationary(), keyframe = needs_keyframe(view, propagation);
    is_stationary_ = was_stationary && propagation.is_stationary();
    was_stationary && !is_stationary_ ? keep_temporary(view) : drop_temporary();
    if (is_stationary_) x.T_world_body = frames().latest().T_world_body;
    temporary_ = backend_.insert(view.t_ns, x, propagation.factor(keyframe_));
    return keyframe;
  }
  /// Optimizes the window with the frame as a keyframe, or as none; `before` is the state of the previous frame. At
  /// rest the window is not optimized, so noise does not move the pose.
  void solve(const View<Sensors>& view, const State& before, bool keyframe, Tracker& tracker,
             const Propagation& propagation, RigState<Sensors>& rig_state) {
    if (keyframe) {
      tracker.detect(view, frames(), landmarks_, temporary_, rig_state.readout().value_s);
    } else {
      landmarks_.for_each([&](auto& store) { store.record(temporary_); });
    }
    if (is_stationary_) return frames().set_latest(temporary_);
    backend_.optimize(view.rig, view.T_body_cam, landmarks_, keyframe);
    if (keyframe && readout_.update(backend_, view, landmarks_, rig_state))
      backend_.optimize(view.rig, view.T_body_cam, landmarks_);
    frames().set_latest(temporary_);
    if (State solved = frames().latest(); propagation.correct(before, solved, view.dt)) frames().set_latest(solved);
  }
  /// Sets the covariance of the navigation state, and that of the velocity, to what the window knows of the latest
  /// frame.
  void update_covariance(Propagation& propagation, Nav& navigation) const {
    if (is_stationary_) return;
    using Known = std::conditional_t<HasVelocityCovariance<Backend>, MovingLayout, VisualLayout>;
    Mat<S, Known::dim, Known::dim> known;
    if (!backend_.covariance_of_newest(known)) set_identity(known);
    navigation.set_window_covariance(block<state::Pose::dim, state::Pose::dim>(known, 0, 0));
    if constexpr (HasVelocityCovariance<Backend>) {
      propagation.set_velocity_covariance(known);
      propagation.set_speed_covariance(known, frames().latest().v_world_body);
    }
  }
  void keep_as_keyframe(const View<Sensors>& view, Tracker& tracker, Propagation& propagation, Nav& navigation) {
    adopt_keyframe(view, temporary_, tracker, propagation, navigation);
    temporary_ = none;
    make_room(view);
  }

  /// Detects landmarks in the latest frame and makes it a keyframe, if it shows at least `min_landmarks` corners.
  /// Earlier landmarks are not observed in it. For a frame whose pose is the predicted one alone.
  bool restart_tracking(const View<Sensors>& view, int min_landmarks, Tracker& tracker, Propagation& propagation,
                        Nav& navigation) {
    drop_temporary();
    landmarks_.for_each([](auto& store) { store.clear_current(); });
    const int slot = backend_.insert(view.t_ns, frames().latest(), propagation.factor(keyframe_));
    tracker.front_ends().detect(view, frames(), landmarks_, slot);
    if (landmarks_.seen_count() < min_landmarks) {
      backend_.drop(landmarks_, slot);
      return false;
    }
    frames().set_latest(slot);
    adopt_keyframe(view, slot, tracker, propagation, navigation);
    make_room(view);
    return true;
  }

  /// Makes `slot` the last keyframe.
  void adopt_keyframe(const View<Sensors>& view, int slot, Tracker& tracker, Propagation& propagation,
                      Nav& navigation) {
    const State x = frames().latest();
    tracker.images().keep(view, x.T_world_body);
    keyframe_ = slot;
    tracked_at_keyframe_ = landmarks_.tracked_count();
    propagation.begin_factor();
    is_latest_keyframe_ = true;
    const bool has_covariance = backend_.covariance_of_newest(keyframe_covariance_);
    map_updates_.adopt(slot, frames(), landmarks_, view.current, view.depth, view.shutter, view.T_body_cam,
                       keyframe_covariance_ + navigation.world().at(x.T_world_body));
    if (Propagation::has_imu_factors && !propagation.is_initialized())
      return;  // its world frame is not that of the navigation
    navigation.set_pose(x.T_world_body);
    if (has_covariance) navigation.set_window_covariance(keyframe_covariance_);
    if constexpr (Propagation::has_imu_factors && !HasVelocityCovariance<Backend>) {
      Mat<S, MovingLayout::dim, MovingLayout::dim> known;
      if (backend_.covariance_of_keyframe(known)) propagation.set_speed_covariance(known, x.v_world_body);
    }
  }

  /// Poses are in another world and unit from now on, x_new = S_new_old x_old.
  void transform_map(const Sim3<S>& S_new_old, const SE3<S>& T_body_cam) {
    map_updates_.transform(S_new_old, T_body_cam);
  }
  /// The initialization was wrong.
  void reject_map() { map_updates_.reject(); }
  /// Hands all keyframes of the window to the map, from the oldest to the newest.
  void hand_over() { map_updates_.hand_over(backend_, landmarks_, temporary_); }

 private:
  double motion_px() const { return landmarks_.motion_since(keyframe_); }
  /// Retires the oldest keyframe of a full window, so that there is a slot for the next frame.
  void make_room(const View<Sensors>& view) {
    if (frames().full()) backend_.retire(view.rig, view.T_body_cam, landmarks_, frames().oldest(), map());
  }
  void drop_temporary() {
    if (temporary_ != none) backend_.drop(landmarks_, std::exchange(temporary_, none));
  }
  /// Makes the last stationary frame a keyframe, so that the next frames have a factor to its zero velocity.
  void keep_temporary(const View<Sensors>& view) {
    if (temporary_ != none) {
      keyframe_ = std::exchange(temporary_, none);
      RigShutter<Sensors> shutter = view.shutter;
      shutter.set_motion(zeros<S, 3>(), zeros<S, 3>(), S(0));  // at rest
      map_updates_.adopt(keyframe_, frames(), landmarks_, view.previous, {}, shutter, view.T_body_cam,
                         keyframe_covariance_);
    }
    make_room(view);
  }

  Landmarks landmarks_;
  Backend backend_;
  KeyframeRule rule_;
  [[no_unique_address]] ReadoutEstimation<Backend> readout_;
  int keyframe_ = 0, temporary_ = none;  ///< slots of the last keyframe, and of the latest frame if it is none
  int min_tracked_;                      ///< fewer landmarks in a frame are few; tuned: docs/decisions/131 (chosen)
  int tracked_at_keyframe_ = 0;
  bool is_stationary_ = false;  ///< the body is at rest, in this frame and the previous one
  bool is_latest_keyframe_ = false;
  MapUpdates<Parts, MapT> map_updates_;
  Covariance keyframe_covariance_ = zeros<Covariance>();
};

}  // namespace plumbline
