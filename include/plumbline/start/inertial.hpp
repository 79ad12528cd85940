#pragma once
/// Start of a rig with an IMU, on top of that of its camera: vision alone, until its poses and the IMU agree on scale,
/// gravity, velocities and biases.                                                docs/math/inertial_window.md

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/motion/imu_intake.hpp"
#include "plumbline/start/alignment_window.hpp"
#include "plumbline/start/settling.hpp"
#include "plumbline/start/start_report.hpp"
#include "plumbline/state/camera_imu_filter.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

struct InertialStartOptions {
  double frame_interval_s = 0.1;       ///< between the poses that are aligned with the IMU
  double gyro_bias_sigma = 0.02;       ///< prior of the first frame [rad/s]
  double accel_bias_sigma = 0.2;       ///< [m/s^2]
  double min_scale_sigma = 0.05;       ///< relative, of the length that the window holds; aligned poses share errors
  double max_rough_scale_sigma = 0.7;  ///< relative, of a pose that is published although its scale is uncertain
  double max_accel_bias_sigmas = 5;    ///< of accel_bias_sigma, when images and readings are first solved together
  double max_time_error_s = 5e-3;      ///< the camera's clock was wrong by more: poses so far are rough
  double max_readout_error_s = 4e-3;   ///< or the readout time of its shutter
  double max_time_sigma_s = 3e-3;      ///< of the camera's clock, when images and readings are first solved together
  double max_time_wait_s = 2;          ///< for that
  double max_contradiction_s = 2;      ///< poses that contradict the readings for longer are of a wrong map
  InertialAlignmentOptions alignment;
  SettlingOptions settling;
};

template <class S, class VisualT>
class InertialStart {
 public:
  using Visual = VisualT;
  static constexpr bool needs_second_view = Visual::needs_second_view;
  struct Options : InertialStartOptions, Visual::Options {};
  static constexpr int bias_rows = state::GyroBias::dim + state::AccelBias::dim;

  explicit InertialStart(const Options& options) : options_(options), visual_(options) {}

  Visual& visual() { return visual_; }
  const Options& options() const { return options_; }

  /// A series of camera poses begins.
  void clear() {
    window_.clear();
    has_estimate_ = false;
    tried_ns_ = 0;
    contradicted_s_ = 0;
  }
  /// One more of them, its position's own noise, the readings since the frame before and what the rig was found to be:
  /// its clock cuts the readings, its readout moves the images. True when it is worth trying to align.
  bool add(TimeNs t_ns, const SE3<S>& T_ref_cam, const Mat<S, 3, 3>& position_covariance,
           const Preintegration<S>& since_last, const auto& rig_state) {
    t_ns_ = t_ns;
    time_offset_s_ = rig_state.time_offset_s();
    const double readout_s = double(rig_state.readout().value_s);
    if (!(std::abs(time_offset_s_ - series_time_offset_s_) < options_.max_time_error_s &&
          std::abs(readout_s - series_readout_s_) < options_.max_readout_error_s)) {
      window_.make_rough();
      series_time_offset_s_ = time_offset_s_;
      series_readout_s_ = readout_s;
    }
    return window_.add(t_ns, T_ref_cam, since_last, options_.frame_interval_s, time_offset_s_, position_covariance);
  }
  /// A keyframe of that time was solved for again.
  void correct(TimeNs t_ns, const SE3<S>& T_ref_cam) { window_.correct(t_ns, T_ref_cam); }

  /// Whether poses and readings agree; `report` says what is missing. While it is much there may be an estimate that
  /// is rough, and of rough poses.
  bool align(const SE3<S>& T_body_cam, double gravity, InitReport& report) {
    InertialAlignmentOptions options = options_.alignment;
    options.metric = !needs_second_view;
    auto found = window_.align(T_body_cam, options, gravity, time_offset_s_, /*with_rough=*/false);
    report.alignment = found.outcome;
    report.excitation = found.excitation;
    report.gravity_norm = found.gravity_norm;
    report.gyro_residual = found.gyro_residual;
    report.scale_sigma = found.scale_sigma;
    if (found.contradicts()) {
      has_estimate_ = false;
      window_.forget_oldest();
    }
    const bool agree = bool(found);
    if (!is_of_use(found) && window_.has_rough()) {
      found = window_.align(T_body_cam, options, gravity, time_offset_s_);
      if (found.contradicts()) {
        has_estimate_ = false;
        window_.forget_rough();
      }
    }
    count_contradiction(report.alignment);
    if (!is_of_use(found)) return false;
    found_ = found;
    has_estimate_ = true;
    contradicted_s_ = 0;
    gravity_ref_ = found_.R_world_ref.inverse() * gravity_in_world<S>(S(gravity));
    return agree;
  }
  /// Whether poses and readings have contradicted each other for long: a map that was begun with wrong readings.
  bool is_contradicted() const { return contradicted_s_ > options_.max_contradiction_s; }

  /// Whether the camera's clock seems right, or will not be found out in reasonable time.
  bool is_in_time(const CameraImuFilter& found, double since_first_view_s) const {
    return found.believes_clock(options_.max_time_sigma_s) || since_first_view_s > options_.max_time_wait_s;
  }

  /// Whether poses and readings were aligned by the clock that was found then: else scale and biases are of another.
  /// Where one comes out otherwise each time the motion does not show it, and the third is as good as any.
  bool judge_clock(double time_offset_s) {
    const bool in_time = std::abs(time_offset_s - time_offset_s_) < options_.max_time_error_s;
    clock_turns_ = in_time || clock_turns_ == max_clock_turns ? 0 : clock_turns_ + 1;
    return clock_turns_ == 0;
  }

  /// Whether there is an alignment, if a rough one.
  bool has_estimate() const { return has_estimate_; }
  double scale_sigma() const { return found_.scale_sigma; }      ///< relative
  double gravity_sigma() const { return found_.gravity_sigma; }  ///< of its direction [rad]
  Vec<S, 3> latest_velocity() const { return found_.v_world_body[found_.v_world_body.size() - 1]; }  ///< [m/s]

  /// Metres in one unit of vision.
  S scale() const { return found_.scale; }
  /// The state in the world of a body that vision has at T_ref_turned, in its own unit and without the lever arm. The
  /// first body is the origin, upright and without yaw. Velocities are open.
  NavState<S> state_of(const SE3<S>& T_ref_turned, const SE3<S>& T_body_cam) const {
    const SO3<S> R_world_ref = upright<S>(gravity_ref_);
    const SE3<S> T_ref_cam = T_ref_turned * SE3<S>(T_body_cam.rotation(), zeros<S, 3>());
    const SE3<S> T_first_body = SE3<S>(T_ref_cam.rotation(), found_.scale * T_ref_cam.p()) * T_body_cam.inverse();
    NavState<S> x;
    x.T_world_body =
        SE3<S>(R_world_ref * T_first_body.rotation(), R_world_ref * Vec<S, 3>(T_first_body.p() + T_body_cam.p()));
    x.bias_gyro = found_.bias_gyro;
    x.bias_accel = found_.bias_accel;
    return x;
  }

  /// Rows on the biases of the first frame.
  Mat<double, bias_rows, InertialLayout::dim> prior_on_biases() const {
    Mat<double, bias_rows, InertialLayout::dim> J;
    set_zero(J);
    for (int k = 0; k < 3; ++k) {
      J(k, InertialLayout::offset<state::GyroBias> + k) = 1 / options_.gyro_bias_sigma;
      J(3 + k, InertialLayout::offset<state::AccelBias> + k) = 1 / options_.accel_bias_sigma;
    }
    return J;
  }

  /// Whether images and readings, solved for together, bear out what was aligned: poses of a wrong scene can be aligned
  /// with the readings of half a second, but then need an accelerometer bias that no sensor has.
  bool believes(const NavState<S>& x) const {
    const double largest = double(max_abs(x.bias_accel));
    return largest <= options_.max_accel_bias_sigmas * options_.accel_bias_sigma;
  }

 private:
  static constexpr int max_clock_turns = 2;
  using Alignment = typename AlignmentWindow<S>::Outcome;
  bool is_of_use(const Alignment& found) const {
    return found || (found.is_rough() && found.scale_sigma < options_.max_rough_scale_sigma);
  }

  /// That gravity is uncertain says neither.
  void count_contradiction(AlignmentOutcome outcome) {
    if (tried_ns_ > 0 && contradicts(outcome)) contradicted_s_ += seconds_between(tried_ns_, t_ns_);
    tried_ns_ = t_ns_;
  }

  Options options_;
  Visual visual_;
  AlignmentWindow<S> window_;
  Alignment found_;
  bool has_estimate_ = false;
  TimeNs t_ns_ = 0, tried_ns_ = 0;                          ///< of the latest pose, and of that when it was last tried
  double contradicted_s_ = 0;                               ///< since poses and readings last agreed
  double time_offset_s_ = 0;                                ///< as it is known now
  int clock_turns_ = 0;                                     ///< in a row, after what was solved by another clock
  double series_time_offset_s_ = 0, series_readout_s_ = 0;  ///< as they were when the poses began that are not rough
  Vec<S, 3> gravity_ref_ = zeros<S, 3>();
};

}  // namespace plumbline
