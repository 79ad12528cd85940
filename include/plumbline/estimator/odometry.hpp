#pragma once
/// What goes on in every frame once there is a map: predict, track, estimate, keyframe, publish. It has one of each of
/// what an estimator is composed of, but for the start.

#include <type_traits>
#include <utility>

#include "plumbline/backend/backend.hpp"
#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/rolling_frames.hpp"
#include "plumbline/feature/motion_estimate.hpp"
#include "plumbline/feature/row_ranges.hpp"
#include "plumbline/frontend/image_pair.hpp"
#include "plumbline/state/origin.hpp"
#include "plumbline/state/rig_state.hpp"

namespace plumbline {

template <class Parts, class MapT>
class Odometry {
 public:
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Motion = typename Parts::Motion;
  using State = typename Motion::State;
  using Predicted = Prediction<State, S>;
  using Landmarks = typename Parts::Landmarks;
  using Backend = typename Parts::Backend;
  using Window = typename Parts::Window;
  using Options = EstimatorOptions<Parts>;
  using Pose = MotionEstimate<Sensors, Landmarks>;
  using Covariance = typename Pose::Covariance;

  Odometry(const Sensors& sensors, const Options& opts)
      : rig(sensors),
        options(opts),
        rig_state(sensors, opts.readout),
        images(opts.rotation),
        landmarks(Parts::FrontEnds::make_landmarks(opts)),
        front_ends(opts),
        motion(sensors, opts.motion),
        backend(opts.backend, opts.motion),
        origin(S(opts.calibration_error), Sensors::has_imu),
        pose_(opts.pose),
        rule_(opts.keyframe) {}

  const Sensors rig;
  const Options options;
  RigState<Sensors> rig_state;
  ImagePair<Sensors> images;
  Landmarks landmarks;
  typename Parts::FrontEnds front_ends;
  Motion motion;
  Backend backend;
  [[no_unique_address]] MapT map;
  Estimate<S> estimate;
  Origin<S> origin;      ///< of what is published
  TimeNs good_ns = 0;    ///< of the last frame whose image was of use, or that stood
  int full_windows = 0;  ///< that were solved

  Window& window() { return backend.window(); }
  const Window& window() const { return backend.window(); }

  /// Mean motion of the landmarks in the image since the last keyframe [px]; 0 when none is seen in both.
  double motion_px() const { return landmarks.motion_since(keyframe_); }
  /// Without those that moved thrice as far as the mean: where a body stands some tracks creep, and things may move.
  double motion_of_most_px() const { return landmarks.motion_since(keyframe_, 3 * motion_px()); }
  int keyframe() const { return keyframe_; }  ///< slot of the last one
  S mean_depth() const { return landmarks.template mean_depth<S>(); }

  /// A frame whose image was taken in, beside the last one that was kept.
  View<Sensors> view_of(const typename Sensors::Frame& frame, bool is_first) {
    const S dt = S(seconds_between(estimate.t_ns, frame.t_ns));
    const State latest = window().latest();
    estimate.time_offset_s = motion.calibrate(rig_state, window());
    estimate.T_body_cam = rig_state.T_body_cam();
    motion.begin_frame(frame.t_ns, is_first ? nullptr : &latest, dt);
    auto view = images.view(rig, frame, motion.T_body_cam(estimate.T_body_cam), rig_state.readout(), dt);
    move_shutter(*this, view, latest);
    return view;
  }

  /// Where the frame is expected; its shutter moves as the body does.
  Predicted predict(View<Sensors>& view) {
    const auto align_motion = [&](const SE3<S>& guess) {
      return images.align_motion(view, guess, mean_depth(), is_after_gap(view.t_ns));
    };
    const Predicted predicted = motion.predict(window().latest(), view, S(blind_s(view.t_ns)), align_motion);
    move_shutter(*this, view, predicted.state);
    return predicted;
  }

  /// Follows all features from the last image and moves T to the pose that most of them agree on; what it lacks.
  /// After a gap, where nothing else tells of the motion, a few that agree by luck are no agreement.
  HealthReason follow(const View<Sensors>& view, const Predicted& predicted, SE3<S>& T) {
    front_ends.follow(view, window(), landmarks, T);
    const auto [asked, agree] = front_ends.agree(view, window(), landmarks, options.ransac, T,
                                                 [&](const SE3<S>& x) { return motion.admits(predicted, x); });
    const bool few = agree < options.recovery.min_landmarks && 2 * agree < asked;
    return !Motion::is_chain && is_after_gap(view.t_ns) && few ? HealthReason::few_inliers : HealthReason::none;
  }

  /// The pose alone, again without its outliers, then with every landmark looked for where it sees them; what it lacks.
  HealthReason find_pose(View<Sensors>& view, const Predicted& predicted, SE3<S>& T, Covariance& covariance) {
    const auto refine = [&] {
      return pose_.refine(rig, view.T_body_cam, landmarks, window(), predicted.state.T_world_body, predicted.prior, T,
                          covariance);
    };
    HealthReason lacks = refine();
    if (lacks == HealthReason::none) {
      know_motion(*this, view, predicted.state, T);
      lacks = refine();
    }
    if (lacks == HealthReason::none) {
      front_ends.refine(view, window(), landmarks, T);
      lacks = refine();
    }
    if (lacks != HealthReason::none) return lacks;
    if (motion.contradicts(predicted, T)) return HealthReason::imu_disagrees;
    know_keyframe_motion(*this, view, predicted.state, T);
    set_ranges(landmarks, window(), view, T, readout_s(), /*all=*/false);
    return HealthReason::none;
  }
  /// Of the place that was found, from its covariance, as small as the errors are that its features have.
  Mat<S, 3, 3> noise_of_place(const Covariance& covariance) const {
    return pose_.noise_scale2() * block<3, 3>(covariance, 3, 3);
  }

  /// A frame that nothing ties to others: its pose is that of its features; a keyframe is solved for with the window.
  void solve_alone(const View<Sensors>& view, const State& x, const Covariance& covariance) {
    window().set_latest(x);
    images.keep(view, x.T_world_body);
    publish(view.t_ns);
    // The keyframe's uncertainty, carried over to this body, plus that of the motion since.
    publish(carried(keyframe_covariance_, window().T_world_body(keyframe_), x.T_world_body) + covariance);
    locate(view);
    good_ns = view.t_ns;
  }
  bool needs_keyframe(TimeNs t_ns) {
    const double rad = motion_px() / double(effective_focal_length(rig.vision.camera));
    const bool needed = rule_.is_keyframe(landmarks.tracked_count(), tracked_at_keyframe_, rad);
    return motion.confirm_keyframe(
        t_ns, [&] { return motion_of_most_px(); }, needed);
  }
  /// The latest frame, which was solved for alone, becomes a keyframe.
  void make_keyframe(const View<Sensors>& view) {
    const int slot = backend.insert(view.t_ns, window().latest(), motion.link(keyframe_));
    look_for_more(view, slot);
    backend.optimize(rig, view.T_body_cam, landmarks);
    if (find_readout(*this, view)) backend.optimize(rig, view.T_body_cam, landmarks);
    window().set_latest(slot);
    adopt_keyframe(view, slot);
    make_room(view);
  }

  /// A frame that is tied to the last keyframe has a place in the window, and is taken out again, without a trace, when
  /// the next one comes, unless it is a keyframe. True when it is to be one.
  bool enter_window(const View<Sensors>& view, State x) {
    const bool rested = motion.at_rest(), keyframe = needs_keyframe(view.t_ns);
    stands_ = rested && motion.at_rest();
    rested && !stands_ ? keep_temporary(view) : drop_temporary();
    if (stands_) x.T_world_body = window().latest().T_world_body;
    temporary_ = backend.insert(view.t_ns, x, motion.link(keyframe_));
    return keyframe;
  }
  /// Solved for as a keyframe, or as none; `before` is the state one frame ago. Noise does not move a body that stands.
  void solve_in_window(const View<Sensors>& view, const State& before, bool keyframe) {
    if (keyframe) {
      look_for_more(view, temporary_);
    } else {
      landmarks.for_each([&](auto& store) { store.record(temporary_); });
    }
    if (stands_) return window().set_latest(temporary_);
    backend.optimize(rig, view.T_body_cam, landmarks, keyframe);
    if (keyframe && find_readout(*this, view)) backend.optimize(rig, view.T_body_cam, landmarks);
    window().set_latest(temporary_);
    if (State solved = window().latest(); motion.revise(before, solved, view.dt)) window().set_latest(solved);
  }
  /// Landmarks without a place in space, by the latest frame's view of them.
  void locate(const View<Sensors>& view) {
    front_ends.locate(view, window(), landmarks, window().latest().T_world_body);
  }
  void publish_in_window(const View<Sensors>& view) {
    images.keep(view, window().latest().T_world_body);
    publish(good_ns = view.t_ns);
    if (stands_) return;
    using Known = std::conditional_t<TellsVelocity<Backend>, MovingLayout, VisualLayout>;
    Mat<S, Known::dim, Known::dim> known;
    if (!backend.covariance_of_newest(known)) set_identity(known);
    publish(block<state::Pose::dim, state::Pose::dim>(known, 0, 0));
    if constexpr (TellsVelocity<Backend>) {
      motion.know_velocity(known);
      motion.know_speed(known, window().latest().v_world_body);
    }
  }
  void stay_in_window(const View<Sensors>& view) {
    adopt_keyframe(view, temporary_);
    temporary_ = none;
    make_room(view);
  }

  /// That of `slot` is the last keyframe now.
  void adopt_keyframe(const View<Sensors>& view, int slot) {
    const State x = window().latest();
    images.keep(view, x.T_world_body);
    keyframe_ = slot;
    tracked_at_keyframe_ = landmarks.tracked_count();
    motion.begin_link(x);
    estimate.keyframe = true;
    const bool knows_covariance = backend.covariance_of_newest(keyframe_covariance_);
    if (Motion::is_chain && !motion.ties_frames()) return;  // its world is not the one that is published
    estimate.T_world_body = x.T_world_body;
    if (knows_covariance) publish(keyframe_covariance_);
    if constexpr (Motion::is_chain && !TellsVelocity<Backend>) {
      Mat<S, MovingLayout::dim, MovingLayout::dim> known;
      if (backend.covariance_of_keyframe(known)) motion.know_speed(known, x.v_world_body);
    }
  }
  /// For the next frame: a keyframe goes to the map when the window is full.
  void make_room(const View<Sensors>& view) {
    if (!window().full()) return;
    // Without depth or links scale goes from frame to frame; with links time does.
    constexpr bool in_order = Motion::is_chain || !Sensors::has_depth;
    const int slot = KeyframeRule::leaving(window(), mean_depth(), in_order);
    backend.retire(rig, view.T_body_cam, landmarks, slot, map);
  }
  void drop_temporary() {
    if (temporary_ != none) backend.drop(landmarks, std::exchange(temporary_, none));
  }

  /// The last frame of a standstill stays: what comes is tied to it.
  void keep_temporary(const View<Sensors>& view) {
    if (temporary_ != none) keyframe_ = std::exchange(temporary_, none);
    make_room(view);
  }

  /// The window has become metric, the latest frame is its last keyframe: links begin.
  void become_metric(const View<Sensors>& view) {
    front_ends.end_start(landmarks);
    good_ns = view.t_ns;
    publish(view.t_ns);
    adopt_keyframe(view, keyframe_);
  }

  /// Forgets all landmarks and frames; the frame is the first keyframe, at x. Returns its slot.
  int begin_anew(const View<Sensors>& view, const State& x) {
    landmarks.for_each([](auto& store) { store.clear(); });
    front_ends.begin_start();
    temporary_ = none;
    begin_readout(*this);
    const int slot = backend.start(view.t_ns, x);
    window().set_latest(slot);
    front_ends.detect(view, window(), landmarks, slot);
    set_zero(keyframe_covariance_);
    return slot;
  }

  void publish(TimeNs t_ns) {
    const State x = window().latest();
    estimate.t_ns = t_ns;
    estimate.T_world_body = x.T_world_body;
    origin.travel_to(x.T_world_body);
    estimate.keyframe = false;
    estimate.tracked = landmarks.tracked_count();
    const bool few = estimate.tracked < 2 * options.pose.min_inliers;
    HealthReason doubt = motion.doubt(backend.links(), window(), few);
    if (doubt == HealthReason::none && few) doubt = HealthReason::few_features;
    set_health(doubt == HealthReason::none ? HealthState::tracking : HealthState::degraded, doubt);
    if constexpr (Motion::Layout::template has<state::Velocity>) {
      if (!motion.ties_frames()) return;
      estimate.v_world_body = x.v_world_body;
      estimate.bias_gyro = x.bias_gyro;
      estimate.bias_accel = x.bias_accel;
    }
  }
  /// The covariance of the published pose, that of the window being P.
  void publish(const Covariance& P) { estimate.covariance = P + origin.at(estimate.T_world_body); }
  void set_health(HealthState state, HealthReason reason) { estimate.health = {state, reason}; }
  double blind_s(TimeNs t_ns) const { return seconds_between(good_ns, t_ns); }
  bool is_after_gap(TimeNs t_ns) const { return blind_s(t_ns) > options.recovery.gap_s; }

  S readout_s() const { return rig_state.readout().value_s; }

 private:
  static constexpr int none = -1;
  /// New landmarks in the keyframe of that slot.
  void look_for_more(const View<Sensors>& view, int slot) {
    front_ends.detect(view, window(), landmarks, slot);
    set_ranges(landmarks, window(), view, window().T_world_body(slot), readout_s(), /*all=*/true);
  }
  Pose pose_;
  KeyframeRule rule_;
  int keyframe_ = 0, temporary_ = none;  ///< slots of the last keyframe, and of the latest frame when it is none
  int tracked_at_keyframe_ = 0;
  bool stands_ = false;  ///< the body, for more than one frame
  Covariance keyframe_covariance_ = zeros<Covariance>();
};

}  // namespace plumbline
