#pragma once
/// Visual and visual-inertial odometry from a rig, feature kinds and a backend, all named in the type:
///
///   using Vio = Estimator<Rig<Rgbd<Pinhole<float>>, Imu>, Features<Points<180>>, SlidingWindow<10>>;
///   static Vio vio{rig, options};                       // every byte it will ever use
///   vio.add_imu({t_ns, gyro, accel});                   // rigs with an IMU: rad/s, m/s^2
///   Result<Estimate<float>> estimate = vio.add_frame({t_ns, gray, depth});
///
/// One frame, front to back: see, predict, track, estimate, keyframe (detect, optimize, retire), publish; when tracking
/// fails: coast, find again, begin anew. Same input, same output, bit for bit. With an executor (executor.hpp) the work
/// on a keyframe goes on beside the caller; what follows waits for it, so that this is as true.

#include "plumbline/core/result.hpp"
#include "plumbline/estimator/beginning.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/executor.hpp"
#include "plumbline/estimator/keyframe_work.hpp"
#include "plumbline/estimator/odometry.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/recovery.hpp"
#include "plumbline/map/no_map.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource = NoClock, class MapPolicy = Forgetful,
          Executor WorkPolicy = InOrder>
class Estimator {
  static_assert(SensorRig<Sensors>, "plumbline: argument 1 must be a rig, e.g. Rig<Rgbd<Pinhole<float>>>");
  using Parts = Composition<Sensors, FeatureSet, BackendPolicy>;
  using Map = typename MapPolicy::template Map<Sensors>;
  using Core = Odometry<Parts, Map>;
  using Covariance = typename Core::Covariance;
  using Predicted = typename Core::Predicted;
  using State = typename Core::State;
  using Work = KeyframeWork<Core, WorkPolicy>;

 public:
  using S = typename Sensors::Scalar;
  using Frame = typename Sensors::Frame;
  using Landmarks = typename Core::Landmarks;
  using Backend = typename Core::Backend;
  using Options = typename Core::Options;

  explicit Estimator(const Sensors& rig, const Options& options = {}) : core_(rig, options), beginning_(options) {}

  /// One reading, before the frame that comes after it: readings up to the frame's time plus the time offset, as far as
  /// it is known (`latest().time_offset_s`). Between two frames the order does not matter. Errors as in ImuBuffer.
  /// (What needs an IMU is a template: to Clang 14 `template class Estimator<...>` asks for it, whatever it requires.)
  template <InertialRig R = Sensors>
  Result<typename ImuBuffer<>::Accepted> add_imu(const ImuSample& sample) {
    const State latest = work_.latest_state(core_);
    return core_.motion.imu().add(sample, beginning_.has_seen_a_frame() ? &latest : nullptr);
  }

  /// Uses one frame; its pixels are not needed after the call. An error leaves the estimator as it was.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (!ImagePair<Sensors>::has_right_size(core_.rig, frame)) return Error::wrong_image_size;
    if (beginning_.has_seen_a_frame() && frame.t_ns <= latest().t_ns) return Error::late_sample;
    Stopwatch<TimeSource> whole, stage;
    work_.wait();
    if (!core_.images.see(frame)) return Error::wrong_image_size;
    timing_ = {.pyramid = stage.lap()};
    View<Sensors> view = core_.view_of(frame, !beginning_.has_seen_a_frame());
    beginning_.reckon(core_, view);
    if (!beginning_.has_first_view()) {
      recovery_.begin(core_, beginning_, view);
    } else if (beginning_.is_refuted()) {
      recovery_.begin_anew(core_, beginning_, view);
    } else {
      const Predicted predicted = core_.predict(view);
      if (!beginning_.has_map()) {
        beginning_.look_for_second_view(core_, view, predicted.state);
      } else {
        go_on(view, predicted, stage);
        beginning_.settle(core_, view);
      }
    }
    work_.end_frame(core_, view);
    timing_.total = whole.lap();
    return latest();
  }

  /// What the last frame returned.
  const Estimate<S>& latest() const { return work_.latest(core_); }
  const FrameTiming& timing() const { return timing_; }
  /// How far the start has come, or what keeps it.
  const InitReport& init_report() const { return beginning_.report(); }

  const Sensors& rig() const { return core_.rig; }

  /// Until work beside the caller is done; so do the three that read what it writes. The next frame waits by itself.
  void wait() const { work_.wait(); }
  const Landmarks& landmarks() const { return wait(), core_.landmarks; }
  const Backend& backend() const { return wait(), core_.backend; }
  const Map& map() const { return wait(), core_.map; }

  const RigState<Sensors>& rig_state() const { return core_.rig_state; }
  template <InertialRig R = Sensors>
  const ImuBuffer<>& imu() const {
    return core_.motion.imu().buffer();
  }
  /// What is found out about the camera's clock and mount while running.
  template <InertialRig R = Sensors>
  const CameraImuFilter& camera_imu() const {
    return core_.motion.camera_imu();
  }
  /// Whether the body stands still, as image and IMU have it.
  template <InertialRig R = Sensors>
  bool at_rest() const {
    return core_.motion.at_rest();
  }

 private:
  void go_on(View<Sensors>& view, const Predicted& predicted, Stopwatch<TimeSource>& stage) {
    const bool knows_motion = core_.motion.carries_on() || !Core::Motion::is_chain;
    if (knows_motion && core_.images.repeats() && !core_.motion.may_rest(view.t_ns))
      return recovery_.recover(core_, beginning_, view, predicted.state, HealthReason::images_repeat);
    SE3<S> T = predicted.state.T_world_body;
    core_.front_ends.align(view, core_.window(), core_.landmarks, predicted.prior, T);
    timing_.align = stage.lap();
    HealthReason lacks = core_.follow(view, predicted, T);
    timing_.follow = stage.lap();
    Covariance covariance;
    if (lacks == HealthReason::none) lacks = core_.find_pose(view, predicted, T, covariance);
    timing_.estimate = stage.lap();
    if (lacks != HealthReason::none) {
      if (core_.landmarks.seen_count() < core_.options.pose.min_inliers) lacks = HealthReason::few_features;
      recovery_.recover(core_, beginning_, view, predicted.state, lacks);
    } else {
      const State x = core_.motion.update(predicted.state, T, covariance, view);
      if (core_.motion.ties_frames()) {
        work_.solve_in_window(core_, view, x);
        judge(predicted);
      } else {
        core_.solve_alone(view, x, covariance);
        const bool worth_aligning = beginning_.gather(core_, view, covariance),
                   needed = core_.needs_keyframe(view.t_ns);
        if (worth_aligning) {
          core_.make_keyframe(view);
          beginning_.align(core_, view);
        } else if (needed) {
          work_.make_keyframe(core_, view);
        }
      }
      recovery_.found_pose(core_, view);
    }
    timing_.map = stage.lap();
  }

  /// Where readings are in doubt and exclude what was solved for, nobody knows who is right; nor how the body
  /// is turned since they are wrong: what leans can be a bias of the accelerometer.
  void judge(const Predicted& predicted) {
    const SE3<S>& T = core_.estimate.T_world_body;
    if (core_.motion.turned_wrongly() > S(0)) core_.origin.doubt_rotation(T, core_.motion.turned_wrongly());
    if (core_.estimate.health.reason == HealthReason::imu_disagrees && !core_.motion.admits(predicted, T))
      core_.origin.dispute(minus(T, predicted.state.T_world_body));
  }

  Core core_;
  Beginning<Core, typename Parts::Start> beginning_;
  Recovery<Core, Beginning<Core, typename Parts::Start>> recovery_;
  FrameTiming timing_;
  [[no_unique_address]] Work work_;  ///< the last, so that its end is waited for first
};

}  // namespace plumbline
