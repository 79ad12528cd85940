#pragma once
/// Calibration state of the rig in use: extrinsics, time offset, readout time.
///
/// It begins with the calibration and is the one source of these values for all other parts, so that an online estimate
/// is used everywhere. Of the blocks of the rig (state/block.hpp) the time offset is estimated by the propagation with
/// an IMU, readout time and extrinsics by the window.

#include "plumbline/core/present.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/readout_estimate.hpp"

namespace plumbline {

template <SensorRig Sensors>
class RigState {
 public:
  using S = typename Sensors::Scalar;
  using Readouts = Present<ReadoutEstimate<S>, Sensors::rolls>;

  RigState(const Sensors& rig, const ReadoutOptions& options)
      : T_body_cam_(rig.T_body_cam()), readout_(ReadoutEstimate<S>(rig.vision.readout.get(), options)) {
    if constexpr (Sensors::has_imu) time_offset_s_.set(rig.imu.camera_time_offset_s);
  }

  /// Extrinsics, state::Extrinsics.
  const SE3<S>& T_body_cam() const { return T_body_cam_; }
  void set_T_body_cam(const SE3<S>& T_body_cam) { T_body_cam_ = T_body_cam; }
  /// Time offset, state::TimeOffset [s]; zero without an IMU.
  double time_offset_s() const { return time_offset_s_.get(); }
  void set_time_offset(double offset_s) { time_offset_s_.set(offset_s); }
  /// Readout time; zero and known for a global shutter.
  Readout<S> readout() const { return readout_.get().readout(); }

  /// Estimated readout time, also while the value in use is held [s].
  S found_readout_s() const { return readout_.get().found_s(); }
  /// Adds a correction of the readout time with its sigma; returns the change of the value in use [s].
  S correct_readout(S correction_s, S sigma_s) {
    ReadoutEstimate<S> estimate = readout_.get();
    estimate.correct(correction_s, sigma_s);
    const S change = estimate.readout().value_s - readout().value_s;
    readout_.set(estimate);
    return change;
  }

 private:
  SE3<S> T_body_cam_;
  [[no_unique_address]] Present<double, Sensors::has_imu> time_offset_s_;
  [[no_unique_address]] Readouts readout_;
};

}  // namespace plumbline
