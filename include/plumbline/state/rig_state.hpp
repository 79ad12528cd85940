#pragma once
/// What is believed of the rig: where the camera sits, how its clock stands to the IMU's, how fast its rows are read.
/// Everybody asks here, nobody the calibration, so that what is found out while running is in force everywhere.
///
/// Of the blocks of the rig (state/block.hpp) the time offset is estimated by the motion model that knows the IMU,
/// readout time and extrinsics by the window.

#include "plumbline/core/present.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/block.hpp"
#include "plumbline/state/readout_belief.hpp"

namespace plumbline {

template <SensorRig Sensors>
class RigState {
 public:
  using S = typename Sensors::Scalar;
  using Readouts = Present<ReadoutBelief<S>, Sensors::rolls>;

  RigState(const Sensors& rig, const ReadoutOptions& options)
      : T_body_cam_(rig.T_body_cam()), readout_(ReadoutBelief<S>(rig.vision.readout.get(), options)) {
    if constexpr (Sensors::has_imu) time_offset_s_.set(rig.imu.camera_time_offset_s);
  }

  /// state::Extrinsics
  const SE3<S>& T_body_cam() const { return T_body_cam_; }
  void set_T_body_cam(const SE3<S>& T_body_cam) { T_body_cam_ = T_body_cam; }
  /// state::TimeOffset; zero without an IMU.
  double time_offset_s() const { return time_offset_s_.get(); }
  void set_time_offset(double offset_s) { time_offset_s_.set(offset_s); }
  /// Zero, and known, of a global shutter.
  Readout<S> readout() const { return readout_.get().readout(); }

  /// The same, whether or not it is held to another value [s].
  S found_readout_s() const { return readout_.get().found_s(); }
  /// It is found to be wrong by that much; returns by how much it changed [s].
  S correct_readout(S correction_s, S sigma_s) {
    ReadoutBelief<S> belief = readout_.get();
    belief.correct(correction_s, sigma_s);
    const S change = belief.readout().value_s - readout().value_s;
    readout_.set(belief);
    return change;
  }

 private:
  SE3<S> T_body_cam_;
  [[no_unique_address]] Present<double, Sensors::has_imu> time_offset_s_;
  [[no_unique_address]] Readouts readout_;
};

}  // namespace plumbline
