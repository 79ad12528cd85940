#pragma once
/// Visual and visual-inertial odometry of a rig, feature kinds and a backend, all named in the type:
///
///   using Vio = Estimator<Rig<Rgbd<Pinhole<float>>, Imu>, Features<Points<180>>, SlidingWindow<10>>;
///   static Vio vio{rig, options};                       // every byte it will ever use
///   vio.add_imu({t_ns, gyro, accel});                   // rigs with an IMU: rad/s, m/s^2
///   Result<Estimate<float>> estimate = vio.add_frame({t_ns, gray, depth});
///
/// Stages of a frame: image pyramid, prediction, tracking, pose estimation, keyframe (detection, window optimization,
/// marginalization), publication. When tracking fails: IMU-only propagation, re-detection, reset. The same input gives
/// the same output, bit for bit. With an executor (executor.hpp) the keyframe task runs beside the caller; every later
/// stage that depends on it waits for it, so the output is still reproducible.

#include "plumbline/core/result.hpp"
#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/estimator/estimate.hpp"
#include "plumbline/estimator/executor.hpp"
#include "plumbline/estimator/initialization.hpp"
#include "plumbline/estimator/keyframe_task.hpp"
#include "plumbline/estimator/odometry.hpp"
#include "plumbline/estimator/options.hpp"
#include "plumbline/estimator/recovery.hpp"
#include "plumbline/map/no_map.hpp"

namespace plumbline {

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource = NoClock, class MapPolicy = NoMap,
          Executor ExecutorPolicy = SynchronousExecutor>
class Estimator {
  static_assert(SensorRig<Sensors>, "plumbline: argument 1 must be a rig, e.g. Rig<Rgbd<Pinhole<float>>>");
  using Parts = Composition<Sensors, FeatureSet, BackendPolicy>;
  using Map = typename MapPolicy::template Map<Sensors>;
  using Core = Odometry<Parts, Map>;
  using Covariance = typename Core::Covariance;
  using Predicted = typename Core::Predicted;
  using State = typename Core::State;
  using Task = KeyframeTask<Core, ExecutorPolicy>;

 public:
  using S = typename Sensors::Scalar;
  using Frame = typename Sensors::Frame;
  using Landmarks = typename Core::Landmarks;
  using Backend = typename Core::Backend;
  using Options = typename Core::Options;

  explicit Estimator(const Sensors& rig, const Options& options = {}) : core_(rig, options), initialization_(options) {}

  /// Adds an IMU sample. All samples up to the frame's time plus the time offset (`latest().time_offset_s`) are to be
  /// added before that frame; samples between two frames may come in any order. Errors as in ImuBuffer.
  /// (Members that need an IMU are templates: Clang 14 instantiates every non-template member in an explicit
  /// instantiation, whatever its requires-clause.)
  template <InertialRig R = Sensors>
  Result<typename ImuBuffer<>::Accepted> add_imu(const ImuSample& sample) {
    const State latest = task_.latest_state(core_);
    return core_.motion.imu().add(sample, initialization_.has_started() ? &latest : nullptr);
  }

  /// Processes a frame; its pixels are not used after the call. On an error the state of the estimator is unchanged.
  Result<Estimate<S>> add_frame(const Frame& frame) {
    if (!ImagePair<Sensors>::has_right_size(core_.rig, frame)) return Error::wrong_image_size;
    if (initialization_.has_started() && frame.t_ns <= latest().t_ns) return Error::late_sample;
    Stopwatch<TimeSource> whole, stage;
    task_.wait();
    if (!core_.images.take_in(frame)) return Error::wrong_image_size;
    timing_ = {.pyramid = stage.lap()};
    View<Sensors> view = core_.view_of(frame, !initialization_.has_started());
    initialization_.dead_reckon(core_, view);
    if (!initialization_.has_first_view()) {
      recovery_.start(core_, initialization_, view);
    } else if (initialization_.is_rejected()) {
      recovery_.reset(core_, initialization_, view);
    } else {
      const Predicted predicted = core_.predict(view);
      if (!initialization_.has_map()) {
        initialization_.find_second_view(core_, view, predicted.state);
      } else {
        track(view, predicted, stage);
        initialization_.verify_scale(core_, view);
      }
    }
    task_.end_frame(core_, view);
    timing_.total = whole.lap();
    return latest();
  }

  /// The estimate of the last frame.
  const Estimate<S>& latest() const { return task_.latest(core_); }
  const FrameTiming& timing() const { return timing_; }
  /// Stage of the initialization, with its figures.
  const InitReport& init_report() const { return initialization_.report(); }

  const Sensors& rig() const { return core_.rig; }

  /// Waits until the keyframe task is done. The three accessors below, which read what it writes, do so themselves, as
  /// does the next frame.
  void wait() const { task_.wait(); }
  const Landmarks& landmarks() const { return wait(), core_.landmarks; }
  const Backend& backend() const { return wait(), core_.backend; }
  const Map& map() const { return wait(), core_.map; }

  const RigState<Sensors>& rig_state() const { return core_.rig_state; }
  template <InertialRig R = Sensors>
  const ImuBuffer<>& imu() const {
    return core_.motion.imu().buffer();
  }
  /// The filter that estimates time offset and extrinsic rotation before initialization.
  template <InertialRig R = Sensors>
  const CameraImuFilter& camera_imu() const {
    return core_.motion.camera_imu();
  }
  /// Whether the body is stationary, by images and IMU.
  template <InertialRig R = Sensors>
  bool is_stationary() const {
    return core_.motion.is_stationary();
  }

 private:
  void track(View<Sensors>& view, const Predicted& predicted, Stopwatch<TimeSource>& stage) {
    const bool can_predict = core_.motion.can_propagate() || !Core::Motion::has_imu_factors;
    if (can_predict && core_.images.repeats() && !core_.motion.can_be_stationary(view.t_ns))
      return recovery_.recover(core_, initialization_, view, predicted.state, HealthReason::images_repeat);
    SE3<S> T = predicted.state.T_world_body;
    core_.front_ends.align(view, core_.window(), core_.landmarks, predicted.prior, T);
    timing_.align = stage.lap();
    HealthReason failure = core_.follow(view, predicted, T);
    timing_.follow = stage.lap();
    Covariance covariance;
    if (failure == HealthReason::none) failure = core_.find_pose(view, predicted, T, covariance);
    timing_.estimate = stage.lap();
    if (failure != HealthReason::none) {
      if (core_.landmarks.seen_count() < core_.options.pose.min_inliers) failure = HealthReason::few_features;
      recovery_.recover(core_, initialization_, view, predicted.state, failure);
    } else {
      const State x = core_.motion.update(predicted.state, T, covariance, view);
      if (core_.motion.is_initialized()) {
        task_.solve_in_window(core_, view, x);
        check_consistency(predicted);
      } else {
        core_.adopt_pose(view, x, covariance);
        const bool ready_to_align = initialization_.add_pose(core_, view, covariance),
                   needed = core_.needs_keyframe(view.t_ns);
        if (ready_to_align) {
          core_.make_keyframe(view);
          initialization_.align(core_, view);
        } else if (needed) {
          task_.make_keyframe(core_, view);
        }
      }
      recovery_.found_pose(core_, view);
    }
    timing_.map = stage.lap();
  }

  /// Adds inflation for unmodeled error to the uncertainty of the world frame: the rotation that a gyroscope bias jump
  /// may have caused, about any axis since tilt is taken for accelerometer bias; and, while images and IMU disagree,
  /// the difference between the solved and the predicted pose when it exceeds the gate.
  void check_consistency(const Predicted& predicted) {
    const SE3<S>& T = core_.estimate.T_world_body;
    if (core_.motion.gyro_jump_rotation() > S(0))
      core_.world_uncertainty.add_rotation_uncertainty(T, core_.motion.gyro_jump_rotation());
    if (core_.estimate.health.reason == HealthReason::imu_disagrees && !core_.motion.passes_gate(predicted, T))
      core_.world_uncertainty.inflate(minus(T, predicted.state.T_world_body));
  }

  Core core_;
  Initialization<Core, typename Parts::Initializer> initialization_;
  Recovery<Core, Initialization<Core, typename Parts::Initializer>> recovery_;
  FrameTiming timing_;
  [[no_unique_address]] Task task_;  ///< the last member: destroyed first, which waits for the task
};

}  // namespace plumbline
