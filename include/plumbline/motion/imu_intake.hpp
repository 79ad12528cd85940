#pragma once
/// The readings of an IMU on their way into an estimator: kept until their frame comes, then integrated.
///                                                                                docs/math/imu.md

#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/sensor/imu.hpp"

namespace plumbline {

template <class S>
class ImuIntake {
 public:
  ImuIntake(const Imu& imu, const ImuNoise& noise)
      : camera_time_offset_s_(imu.camera_time_offset_s), noise_(noise), buffer_(imu.limits), since_frame_(noise) {}

  /// One reading; `state` is that of the last frame, null before the first one. Errors as in ImuBuffer.
  Result<typename ImuBuffer<>::Accepted> add(const ImuSample& sample, const NavState<S>* state) {
    const auto accepted = buffer_.add(sample);
    // Images that do not come: what the buffer is about to forget is integrated before.
    if (state && buffer_.full() && buffer_[1].t_ns > integrated_ns_)
      integrate_readings(buffer_[buffer_.size() / 2].t_ns, *state);
    return accepted;
  }

  /// The readings from the last frame, whose state is given, to one at that time of the camera.
  void integrate(TimeNs t_ns, const NavState<S>& state) { integrate_readings(time_of(t_ns), state); }

  /// There is a frame at that time of the camera: what comes later is since that frame.
  void begin_frame(TimeNs t_ns) {
    integrated_ns_ = time_of(t_ns);
    between_frames_ = false;
  }

  /// The clock of the camera is set; what lies between the last frame's time before and after is of the next one.
  void set_camera_time_offset(double offset_s) { camera_time_offset_s_ = offset_s; }

  /// No reading yet, about the biases of a state.
  Preintegration<S> since(const NavState<S>& state) const {
    return Preintegration<S>(noise_, state.bias_gyro, state.bias_accel);
  }

  const Preintegration<S>& since_frame() const { return since_frame_; }
  const ImuCoverage& coverage() const { return coverage_; }  ///< of the time since the last frame
  bool missing() const { return !(coverage_.missing() < 0.5); }
  /// Whether the readings since the last frame say nothing about the translation.
  bool blind() const { return missing() || coverage_.saturated_s > 0 || accel_doubt_ > S(0); }
  /// The accelerometer errs by that sigma all the while, whatever it says [m/s^2].
  void doubt_accelerometer(S sigma) { accel_doubt_ = sigma; }

  /// Mean of the last readings that were integrated [rad/s]; zero when there is none.
  Vec<S, 3> latest_gyro(double duration_s) const {
    Vec<S, 3> sum = zeros<S, 3>();
    S t = S(0);
    const auto& intervals = since_frame_.intervals();
    for (std::size_t k = intervals.size(); k > 0 && t < S(duration_s); --k) {
      sum += intervals[k - 1].dt * intervals[k - 1].mean_gyro();
      t += intervals[k - 1].dt;
    }
    return t > S(0) ? Vec<S, 3>(sum / t) : sum;
  }

  const ImuBuffer<>& buffer() const { return buffer_; }
  /// A time of the camera on the IMU's clock.
  TimeNs time_of(TimeNs t_ns) const { return t_ns + static_cast<TimeNs>(camera_time_offset_s_ * 1e9); }

 private:
  void integrate_readings(TimeNs until_ns, const NavState<S>& state) {
    if (!between_frames_) {
      since_frame_ = since(state);
      coverage_ = {};
      between_frames_ = true;
    }
    coverage_ += buffer_.for_each_interval(integrated_ns_, until_ns, [&](const ImuInterval<double>& interval) {
      ImuInterval<S> cast = interval.template cast<S>();
      if (accel_doubt_ > S(0)) cast.doubt_accelerometer(accel_doubt_);
      since_frame_.add(cast);
    });
    buffer_.mark_used(until_ns);
    integrated_ns_ = until_ns;
  }

  double camera_time_offset_s_;
  ImuNoise noise_;
  ImuBuffer<> buffer_;
  Preintegration<S> since_frame_;
  ImuCoverage coverage_;
  S accel_doubt_ = S(0);
  TimeNs integrated_ns_ = 0;     ///< readings are integrated up to there
  bool between_frames_ = false;  ///< some of them since the last frame
};

}  // namespace plumbline
