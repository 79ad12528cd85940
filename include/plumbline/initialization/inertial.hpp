#pragma once
/// Visual-inertial initializer: aligns the poses of a visual initializer with the IMU, for scale, gravity, velocities
/// and biases.                                                                    docs/math/inertial_window.md

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/initialization/alignment_window.hpp"
#include "plumbline/initialization/init_report.hpp"
#include "plumbline/initialization/scale_verification.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/propagation/imu_integrator.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

struct InertialInitializerOptions {
  double frame_interval_s = 0.1;  ///< interval of the aligned poses [s]; tuned: docs/decisions/132 (chosen)
  double gyro_bias_sigma = 0.02;  ///< prior of the first frame, each axis [rad/s]; tuned: docs/decisions/132 (chosen)
  double accel_bias_sigma = 0.2;  ///< prior of the first frame, each axis [m/s^2]; tuned: docs/decisions/024
  /// Smallest relative sigma of the length that the restarted window holds. Errors of the aligned poses are correlated;
  /// tuned: docs/decisions/025.
  double min_scale_sigma = 0.05;
  /// Largest relative sigma of the scale of an up-to-scale pose that is published; tuned: docs/decisions/009.
  double max_uncertain_scale_sigma = 0.7;
  /// Largest accelerometer bias in the first joint solution, in units of accel_bias_sigma; tuned: docs/decisions/008.
  double max_accel_bias_sigmas = 5;
  /// Change of the time offset beyond which the poses so far are outdated [s]; tuned: docs/decisions/027.
  double max_time_error_s = 5e-3;
  /// Change of the readout time beyond which the poses so far are outdated [s]; tuned: docs/decisions/132 (chosen).
  double max_readout_error_s = 4e-3;
  /// Sigma of the time offset below which it is accepted for the first joint solution [s];
  /// tuned: docs/decisions/132 (chosen).
  double max_time_sigma_s = 3e-3;
  /// Longest wait for a significant time offset error to be estimated to that sigma, from the first view on [s];
  /// tuned: docs/decisions/027.
  double max_time_wait_s = 2;
  /// Time of contradicting poses and IMU samples after which the map is rejected [s]; tuned: docs/decisions/008.
  double max_contradiction_s = 2;
  InertialAlignmentOptions alignment;
  ScaleVerificationOptions scale_verification;
};

template <class S, class VisualT>
class InertialInitializer {
 public:
  using Visual = VisualT;
  static constexpr bool needs_second_view = Visual::needs_second_view;
  struct Options : InertialInitializerOptions, Visual::Options {};
  static constexpr int bias_rows = state::GyroBias::dim + state::AccelBias::dim;

  explicit InertialInitializer(const Options& options) : options_(options), visual_(options) {}

  Visual& visual() { return visual_; }
  const Options& options() const { return options_; }

  /// Starts a new series of camera poses.
  void clear() {
    window_.clear();
    has_estimate_ = false;
    last_attempt_ns_ = 0;
    contradicted_s_ = 0;
  }
  /// Adds a camera pose, with the covariance of its position, the increment since the previous frame, and the state of
  /// the rig, whose time offset and readout time they depend on. True when an alignment is to be tried.
  bool add(TimeNs t_ns, const SE3<S>& T_ref_cam, const Mat<S, 3, 3>& position_covariance,
           const Preintegration<S>& since_last, const auto& rig_state) {
    t_ns_ = t_ns;
    time_offset_s_ = rig_state.time_offset_s();
    const double readout_s = double(rig_state.readout().value_s);
    if (!(std::abs(time_offset_s_ - series_time_offset_s_) < options_.max_time_error_s &&
          std::abs(readout_s - series_readout_s_) < options_.max_readout_error_s)) {
      window_.mark_outdated();
      series_time_offset_s_ = time_offset_s_;
      series_readout_s_ = readout_s;
    }
    return window_.add(t_ns, T_ref_cam, since_last, options_.frame_interval_s, time_offset_s_, position_covariance);
  }
  /// Replaces the pose of the keyframe of that time by its solution.
  void correct(TimeNs t_ns, const SE3<S>& T_ref_cam) { window_.correct(t_ns, T_ref_cam); }

  /// Aligns poses and IMU; `report` gets the figures. Returns whether the poses that are not outdated are aligned. If
  /// not, there may still be an estimate, of uncertain scale or from all poses.
  bool align(const SE3<S>& T_body_cam, double gravity, InitReport& report) {
    InertialAlignmentOptions options = options_.alignment;
    options.metric = !needs_second_view;
    auto found = window_.align(T_body_cam, options, gravity, time_offset_s_, /*with_outdated=*/false);
    report.alignment = found.outcome;
    report.excitation = found.excitation;
    report.gravity_norm = found.gravity_norm;
    report.gyro_residual = found.gyro_residual;
    report.scale_sigma = found.scale_sigma;
    if (found.contradicts()) {
      has_estimate_ = false;
      window_.discard_oldest();
    }
    const bool is_consistent = bool(found);
    if (!is_usable(found) && window_.has_outdated()) {
      found = window_.align(T_body_cam, options, gravity, time_offset_s_);
      if (found.contradicts()) {
        has_estimate_ = false;
        window_.discard_outdated();
      }
    }
    count_contradiction(report.alignment);
    if (!is_usable(found)) return false;
    found_ = found;
    has_estimate_ = true;
    contradicted_s_ = 0;
    gravity_ref_ = found_.R_world_ref.inverse() * gravity_in_world<S>(S(gravity));
    return is_consistent;
  }
  /// Whether poses and IMU samples have contradicted each other for max_contradiction_s: the map is wrong.
  bool is_contradicted() const { return contradicted_s_ > options_.max_contradiction_s; }

  /// Whether the time offset is accepted by the filter, or the wait for it is over.
  bool is_time_offset_known(const CameraImuFilter& found, double since_first_view_s) const {
    return found.accepts_time_offset(options_.max_time_sigma_s) || since_first_view_s > options_.max_time_wait_s;
  }

  /// Whether the time offset of the joint solution is that of the alignment; otherwise scale and biases are wrong. It
  /// is accepted after max_offset_rejections in a row, because the motion does not determine it then.
  bool verify_time_offset(double time_offset_s) {
    const bool is_consistent = std::abs(time_offset_s - time_offset_s_) < options_.max_time_error_s;
    offset_rejections_ = is_consistent || offset_rejections_ == max_offset_rejections ? 0 : offset_rejections_ + 1;
    return offset_rejections_ == 0;
  }

  /// Whether there is an alignment, possibly of uncertain scale.
  bool has_estimate() const { return has_estimate_; }
  double scale_sigma() const { return found_.scale_sigma; }      ///< relative
  double gravity_sigma() const { return found_.gravity_sigma; }  ///< of the direction of gravity [rad]
  Vec<S, 3> latest_velocity() const { return found_.v_world_body[found_.v_world_body.size() - 1]; }  ///< [m/s]

  /// Meters per unit of length of the visual poses.
  S scale() const { return found_.scale; }
  /// The metric state of the body that vision has at T_ref_rotated, in its own unit and without the lever arm. The
  /// world has the first body at its origin, z up, and zero yaw of the first body. The velocity is not set.
  NavState<S> state_of(const SE3<S>& T_ref_rotated, const SE3<S>& T_body_cam) const {
    const SO3<S> R_world_ref = upright<S>(gravity_ref_);
    const SE3<S> T_ref_cam = T_ref_rotated * SE3<S>(T_body_cam.rotation(), zeros<S, 3>());
    const SE3<S> T_first_body = SE3<S>(T_ref_cam.rotation(), found_.scale * T_ref_cam.p()) * T_body_cam.inverse();
    NavState<S> x;
    x.T_world_body =
        SE3<S>(R_world_ref * T_first_body.rotation(), R_world_ref * Vec<S, 3>(T_first_body.p() + T_body_cam.p()));
    x.bias_gyro = found_.bias_gyro;
    x.bias_accel = found_.bias_accel;
    return x;
  }

  /// Rows of the bias prior of the first frame.
  Mat<double, bias_rows, InertialLayout::dim> prior_on_biases() const {
    Mat<double, bias_rows, InertialLayout::dim> J;
    set_zero(J);
    for (int k = 0; k < 3; ++k) {
      J(k, InertialLayout::offset<state::GyroBias> + k) = 1 / options_.gyro_bias_sigma;
      J(3 + k, InertialLayout::offset<state::AccelBias> + k) = 1 / options_.accel_bias_sigma;
    }
    return J;
  }

  /// Whether the accelerometer bias of the first joint solution is plausible. Poses of a wrong map can be aligned with
  /// the IMU for half a second, but only with a bias that no sensor has.
  bool is_plausible(const NavState<S>& x) const {
    const double max_bias = double(max_abs(x.bias_accel));
    return max_bias <= options_.max_accel_bias_sigmas * options_.accel_bias_sigma;
  }

 private:
  static constexpr int max_offset_rejections = 2;  ///< in a row; tuned: docs/decisions/031
  using Alignment = typename AlignmentWindow<S>::Outcome;
  bool is_usable(const Alignment& found) const {
    return found || (found.is_uncertain() && found.scale_sigma < options_.max_uncertain_scale_sigma);
  }

  /// Adds the time since the last attempt when the outcome is a contradiction. An uncertain gravity is none.
  void count_contradiction(AlignmentOutcome outcome) {
    if (last_attempt_ns_ > 0 && contradicts(outcome)) contradicted_s_ += seconds_between(last_attempt_ns_, t_ns_);
    last_attempt_ns_ = t_ns_;
  }

  Options options_;
  Visual visual_;
  AlignmentWindow<S> window_;
  Alignment found_;
  bool has_estimate_ = false;
  TimeNs t_ns_ = 0, last_attempt_ns_ = 0;                   ///< of the latest pose, and of the last attempt to align
  double contradicted_s_ = 0;                               ///< time of contradiction since the last alignment [s]
  double time_offset_s_ = 0;                                ///< present time offset [s]
  int offset_rejections_ = 0;                               ///< of the time offset, in a row
  double series_time_offset_s_ = 0, series_readout_s_ = 0;  ///< of the poses that are not outdated [s]
  Vec<S, 3> gravity_ref_ = zeros<S, 3>();
};

}  // namespace plumbline
