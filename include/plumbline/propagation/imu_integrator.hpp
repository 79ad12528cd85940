#pragma once
/// Buffer of IMU samples and their integration from frame to frame.                     docs/math/imu.md

#include "plumbline/core/result.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/imu_buffer.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/sensor/imu.hpp"

namespace plumbline {

template <class S>
class ImuIntegrator {
 public:
  ImuIntegrator(const Imu& imu, const ImuNoise& noise)
      : camera_time_offset_s_(imu.camera_time_offset_s), noise_(noise), buffer_(imu.limits), since_frame_(noise) {}

  /// Adds a sample; `state` is that of the last frame, null before the first one. Errors as in ImuBuffer.
  Result<typename ImuBuffer<>::Accepted> add(const ImuSample& sample, const NavState<S>* state) {
    const auto accepted = buffer_.add(sample);
    // Without frames for a long time: samples are integrated before the buffer overwrites them.
    if (state && buffer_.full() && buffer_[1].t_ns > integrated_ns_)
      integrate_until(buffer_[buffer_.size() / 2].t_ns, *state);
    return accepted;
  }

  /// Integrates the samples from the last frame, in the given state, to the image time t_ns.
  void integrate(TimeNs t_ns, const NavState<S>& state) { integrate_until(time_of(t_ns), state); }

  /// A frame at the image time t_ns: later samples belong to the next increment.
  void begin_frame(TimeNs t_ns) {
    integrated_ns_ = time_of(t_ns);
    between_frames_ = false;
  }

  /// Sets the time offset. Samples between the old and the new boundary of the last frame belong to the next increment.
  void set_camera_time_offset(double offset_s) { camera_time_offset_s_ = offset_s; }

  const ImuNoise& noise() const { return noise_; }
  const Preintegration<S>& since_frame() const { return since_frame_; }
  const ImuCoverage& coverage() const { return coverage_; }  ///< of the time since the last frame
  bool is_missing() const { return !(coverage_.missing() < max_missing); }
  /// Whether the samples since the last frame do not determine the translation.
  bool is_unusable() const { return is_missing() || coverage_.saturated_s > 0 || suspect_accel_sigma_ > S(0); }
  /// Sets an additional accelerometer noise for all samples from now on: sigma over one second [m/s^2], 0 for none.
  void inflate_accelerometer_noise(S sigma) { suspect_accel_sigma_ = sigma; }

  /// Mean of the gyroscope over the last duration_s of the increment [rad/s]; zero without samples.
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
  /// An image time on the clock of the IMU.
  TimeNs time_of(TimeNs t_ns) const { return t_ns + static_cast<TimeNs>(camera_time_offset_s_ * 1e9); }

 private:
  void integrate_until(TimeNs until_ns, const NavState<S>& state) {
    if (!between_frames_) {
      since_frame_ = Preintegration<S>(noise_, state.bias_gyro, state.bias_accel);
      coverage_ = {};
      between_frames_ = true;
    }
    coverage_ += buffer_.for_each_interval(integrated_ns_, until_ns, [&](const ImuInterval<double>& interval) {
      ImuInterval<S> cast = interval.template cast<S>();
      if (suspect_accel_sigma_ > S(0)) cast.inflate_accelerometer_noise(suspect_accel_sigma_);
      since_frame_.add(cast);
    });
    buffer_.mark_used(until_ns);
    integrated_ns_ = until_ns;
  }

  /// Part of the time since the last frame; tuned: docs/decisions/017.
  static constexpr double max_missing = 0.5;

  double camera_time_offset_s_;
  ImuNoise noise_;
  ImuBuffer<> buffer_;
  Preintegration<S> since_frame_;
  ImuCoverage coverage_;
  S suspect_accel_sigma_ = S(0);
  TimeNs integrated_ns_ = 0;     ///< end of the samples that are integrated
  bool between_frames_ = false;  ///< since_frame_ has been started since the last frame
};

}  // namespace plumbline
