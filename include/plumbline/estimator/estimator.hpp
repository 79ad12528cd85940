#pragma once
/// Visual and visual-inertial odometry from a rig, feature kinds and a backend, all named in the type:
///
///   using Vio = Estimator<Rig<Rgbd<Pinhole<float>>, Imu>, Features<Points<180>>, SlidingWindow<10>>;
///   static Vio vio{rig, options};                       // every byte it will ever use
///   vio.add_imu({t_ns, gyro, accel});                   // rigs with an IMU: rad/s, m/s^2
///   Result<Estimate<float>> estimate = vio.add_frame({t_ns, gray, depth});
///
/// One frame: take in, predict, track, solve, keyframe (detect, optimize, retire), publish. Which of these a frame goes
/// through depends on the tracking state (tracking_state.hpp); initialization is in initialization/, frames without a
/// pose are in outage.hpp. Same input, same output, bit for bit, with any executor (executor.hpp).

#include <cstdint>
#include <utility>

#include "plumbline/backend/backend.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/estimator/accept_pose.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/frame_in_map.hpp"
#include "plumbline/estimator/frame_tracker.hpp"
#include "plumbline/estimator/keyframe_task.hpp"
#include "plumbline/estimator/keyframe_window.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/outage.hpp"
#include "plumbline/estimator/publisher.hpp"
#include "plumbline/estimator/take_in.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/initialization/initialization.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/state/navigation.hpp"
#include "plumbline/state/tracking_state.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource = NoClock, class MapChoice = NoMap,
          Executor ExecutorPolicy = SynchronousExecutor>
class Estimator {
  static_assert(SensorRig<Sensors>, "plumbline: argument 1 must be a rig, e.g. Rig<Rgbd<Pinhole<float>>>");
  using Parts = Composition<Sensors, FeatureSet, BackendPolicy>;
  static_assert(MapPolicy<MapChoice, Parts>, "plumbline: argument 5 must name a map, see map/map.hpp");
  using Map = typename MapChoice::template Map<Parts>;
  using Propagation = typename Parts::Propagation;
  using State = typename Propagation::State;
  using Window = KeyframeWindow<Parts, Map>;
  using Tracker = FrameTracker<Parts>;
  using Covariance = typename Tracker::Covariance;
  using Predicted = typename Tracker::Predicted;

 public:
  using S = typename Sensors::Scalar;
  using Frame = typename Sensors::Frame;
  using Landmarks = typename Parts::Landmarks;
  using Backend = typename Parts::Backend;
  using Options = EstimatorOptions<Parts>;
  using MapOptions = typename MapChoice::Options;

  explicit Estimator(const Sensors& rig, const Options& options = {}, const MapOptions& map_options = {})
      : rig_(rig),
        max_lost_frames_(options.recovery.max_lost_frames),
        min_inliers_(options.pose.min_inliers),
        rig_state_(rig, options.readout),
        tracker_(options),
        window_(rig, options, map_options),
        propagation_(rig, options.propagation),
        navigation_(WorldFrameUncertainty<S>(S(options.calibration_error), Sensors::has_imu)),
        initialization_(options),
        outage_(options) {}

  /// Adds an IMU sample. All samples up to the frame's time plus the time offset (`latest().time_offset_s`) are to be
  /// added before that frame; samples between two frames may come in any order. Errors as in ImuBuffer.
  /// (Members that need an IMU are templates: Clang 14 instantiates every non-template member in an explicit
  /// instantiation, whatever its requires-clause.)
  template <InertialRig R = Sensors>
  Result<typename ImuBuffer<>::Accepted> add_imu(const ImuSample& sample) {
    const State latest = task_.latest_state();
    return propagation_.imu().add(sample, has_frames_ ? &latest : nullptr);
  }

  /// Processes a frame; its pixels are not used after the call. On an error the state of the estimator is unchanged.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (!ImagePair<Sensors>::has_right_size(rig_, frame)) return Error::wrong_image_size;
    if (has_frames_ && frame.t_ns <= latest().t_ns) return Error::late_sample;
    Stopwatch<TimeSource> whole, stage;
    task_.wait();
    if (!tracker_.images().take_in(frame)) return Error::wrong_image_size;
    window_.work_on_map();
    timing_ = {.pyramid = stage.lap()};
    View<Sensors> view = plumbline::take_in(components(), rig_, frame, !std::exchange(has_frames_, true));
    initialization_.dead_reckon(propagation_, view.dt);
    report_ = {};
    const int previous_keyframe = window_.begin_frame();
    if (std::exchange(reset_requested_, false) && status_.has_first_view()) {
      reset(view, TrackingEvent::reset_requested);
    } else if (initialization_.is_rejected()) {
      reset(view, TrackingEvent::initialization_rejected);
    } else if (!status_.has_first_view()) {
      initialize(view);
    } else {
      const Predicted predicted = plumbline::predict(components(), view);
      if (status_.has_landmarks()) {
        track(view, predicted, previous_keyframe, stage);
        initialization_.verify_scale(view, propagation_, report_.is_inconsistent);
      } else {
        (void)in_map_.find(view, window_.map(), predicted.state.T_world_body);
        initialization_.find_second_view(view, predicted.state,
                                         S(in_map_.distance_from(initialization_.first_view_ns())), components());
        if (!status_.has_landmarks()) find_in_map(view);
      }
    }
    navigation_.set_time(view.t_ns);
    publisher_.publish(navigation_, rig_state_, report_, status_, initialization_.is_scale_converged(),
                       window_.is_latest_keyframe() || task_.is_planned());
    task_.end_frame(components(), view);
    timing_.total = whole.lap();
    return latest();
  }

  /// Excludes the zero pixels of an image of the size of the frames, and those within ImageMask::margin_px of them,
  /// from the next frame on: no feature is detected or observed there. It is copied, one bit a pixel; an empty one
  /// removes the mask. Returns whether there is a mask now; on an error the mask is unchanged.
  Result<bool> set_mask(const ImageView<const std::uint8_t>& mask) {
    task_.wait();
    if (!tracker_.images().set_mask(rig_, mask)) return Error::wrong_image_size;
    return !mask.empty();
  }

  /// The next frame begins a new initialization, at the pose that is estimated then.
  void request_reset() { reset_requested_ = true; }

  /// Attaches a factor of the latest frame, of a type that the backend policy names (factor/factor.hpp), for the next
  /// solution and on. False, and nothing attached, unless tracking is nominal and that frame is a keyframe: any other
  /// frame is removed when the next one comes.
  template <class F>
  bool add_factor(const F& factor) requires TakesFactor<Backend, F> {
    task_.wait();
    return status_.state() == TrackingState::nominal && window_.is_latest_keyframe() &&
           window_.backend().add_factor(window_.keyframe(), factor);
  }

  /// The estimate of the last frame.
  const Estimate<S>& latest() const { return publisher_.latest(); }
  const FrameTiming& timing() const { return timing_; }
  TrackingState tracking_state() const { return status_.state(); }
  /// Stage of the initialization, with its figures.
  const InitReport& init_report() const { return initialization_.report(); }

  const Sensors& rig() const { return rig_; }

  /// Waits until the keyframe task is done. The accessors below that read what it writes do so themselves, as does the
  /// next frame.
  void wait() const { task_.wait(); }
  /// The executor, e.g. one whose work is done in an idle loop.
  ExecutorPolicy& executor() { return task_.executor(); }
  const Landmarks& landmarks() const { return wait(), window_.landmarks(); }
  const Backend& backend() const { return wait(), window_.backend(); }
  const Map& map() const { return wait(), window_.map(); }
  /// To be changed between two frames, as by taking in a saved map before the first one.
  Map& map() { return wait(), window_.map(); }
  /// Hands the keyframes of the window to the map as they are, so that it can be saved with them; they are not changed
  /// in it afterwards.
  void hand_over_keyframes() { wait(), window_.hand_over(); }
  /// Calibration as estimated so far. Of a rolling shutter the task estimates the readout time, so it is waited for.
  const RigState<Sensors>& rig_state() const {
    if constexpr (Sensors::rolls) wait();
    return rig_state_;
  }
  template <InertialRig R = Sensors>
  const ImuBuffer<>& imu() const {
    return propagation_.imu().buffer();
  }
  /// The filter that estimates time offset and extrinsic rotation before initialization.
  template <InertialRig R = Sensors>
  const CameraImuFilter& camera_imu() const {
    return propagation_.camera_imu();
  }
  /// Whether the body is stationary, by images and IMU.
  template <InertialRig R = Sensors>
  bool is_stationary() const {
    return propagation_.is_stationary();
  }

 private:
  Components<Parts, Map> components() {
    return {tracker_, window_, propagation_, rig_state_, navigation_, report_, status_};
  }

  /// Tracks the frame's features and solves for its state; `previous_keyframe` is the slot of the previous frame if
  /// that is a keyframe, else -1.
  void track(View<Sensors>& view, const Predicted& predicted, int previous_keyframe, Stopwatch<TimeSource>& stage) {
    const bool can_predict = propagation_.can_propagate() || !Propagation::has_imu_factors;
    if (can_predict && tracker_.images().repeats() && !propagation_.can_be_stationary(view.t_ns))
      return bridge(view, predicted.state, HealthReason::images_repeat);
    auto& landmarks = window_.landmarks();
    SE3<S> T = predicted.state.T_world_body;
    tracker_.front_ends().align(view, window_.frames(), landmarks, predicted.prior, T);
    timing_.align = stage.lap();
    HealthReason failure = tracker_.follow(view, predicted, propagation_, window_.frames(), landmarks, T);
    timing_.follow = stage.lap();
    Covariance covariance;
    if (failure == HealthReason::none)
      failure = tracker_.find_pose(view, predicted, propagation_, window_.frames(), landmarks, previous_keyframe,
                                   rig_state_.readout().value_s, T, covariance);
    timing_.estimate = stage.lap();
    if (failure != HealthReason::none) {
      bridge(view, predicted.state, landmarks.seen_count() < min_inliers_ ? HealthReason::few_features : failure);
    } else {
      status_.handle(TrackingEvent::pose_found);
      const State x = propagation_.update(predicted.state, T, covariance, view);
      if (propagation_.is_initialized()) {
        task_.solve_in_window(components(), view, x);
        inflate_world_frame(propagation_, report_, predicted, navigation_);
      } else {
        task_.accept_alone(components(), view, x, covariance, initialization_);
      }
      outage_.found_pose(propagation_, view);
    }
    timing_.map = stage.lap();
  }

  /// A frame without a pose: its navigation state is propagated or held, or the estimator is reset.
  void bridge(const View<Sensors>& view, const State& predicted, HealthReason failure) {
    const int max_lost_frames = initialization_.lost_frame_limit(max_lost_frames_);
    if (!outage_.bridge(view, failure, predicted, max_lost_frames, components()))
      return reset(view, TrackingEvent::outage_too_long);
    if (failure != HealthReason::images_repeat) find_in_map(view);
  }

  /// Begins a new initialization with this frame, at the pose of the navigation state.
  void reset(const View<Sensors>& view, TrackingEvent event) {
    status_.handle(event);
    if (event == TrackingEvent::initialization_rejected) window_.reject_map();
    if (!Propagation::has_imu_factors || propagation_.can_propagate())
      initialization_.mark_lost(window_.frames(), navigation_);
    outage_.reset();
    initialize(view);
  }
  void initialize(const View<Sensors>& view) {
    const bool is_in_map = in_map_.find(view, window_.map(), window_.frames().latest().T_world_body);
    if (is_in_map) {
      in_map_.begin_at(view, window_.frames(), navigation_);
      initialization_.mark_lost(window_.frames(), navigation_);
    } else if (!Propagation::has_imu_factors && status_.resets() > 0) {
      outage_.inflate(view, tracker_, navigation_);
      initialization_.mark_lost(window_.frames(), navigation_);
    }
    initialization_.set_first_view(view, components());
    if (is_in_map) in_map_.apply(navigation_, report_);
  }
  /// The pose of a frame that the window has none for, by the map. A first view that is not in the map is replaced.
  void find_in_map(const View<Sensors>& view) {
    if (!in_map_.find(view, window_.map(), window_.frames().latest().T_world_body)) return;
    if (!status_.has_landmarks() && !in_map_.has_begun_at(initialization_.first_view_ns())) return initialize(view);
    in_map_.apply(navigation_, report_);
  }

  const Sensors rig_;
  int max_lost_frames_, min_inliers_;
  RigState<Sensors> rig_state_;
  Tracker tracker_;
  Window window_;
  Propagation propagation_;
  Navigation<S, typename Propagation::Layout> navigation_;
  Initialization<Parts> initialization_;
  Outage<Parts, Map> outage_;
  [[no_unique_address]] FrameInMap<Parts, Map> in_map_;
  TrackingStatus status_;
  FrameReport report_;
  Publisher<S> publisher_;
  bool has_frames_ = false, reset_requested_ = false;
  FrameTiming timing_;
  [[no_unique_address]] KeyframeTask<Parts, Map, ExecutorPolicy> task_;  ///< the last member: destroyed first
};

}  // namespace plumbline
