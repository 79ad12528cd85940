#pragma once
/// Samples on their way from the thread that receives them to the estimator, in the order in which a recording has
/// them: before a frame come the IMU samples up to its time and the first one at or after it.

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>

#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"

/// `Frame::t_ns` is the time of a frame for the estimator.
template <class Frame>
class SampleQueue {
 public:
  using Sample = std::variant<plumbline::ImuSample, Frame>;
  struct Options {
    std::size_t capacity;  ///< frames that wait
    bool sender_waits;     ///< where they are more; else the oldest one is dropped
    bool with_imu;
  };
  static constexpr std::size_t most_imu = 1'000'000;  ///< samples that wait

  SampleQueue(const Options& options, const std::atomic<bool>& stop) : options_(options), stop_(stop) {}

  /// Of the thread that receives. False where more than `most_imu` samples wait for a frame.
  bool add(const plumbline::ImuSample& sample) {
    const std::lock_guard lock(mutex_);
    if (imu_.size() == most_imu) return false;
    imu_.push_back(sample);
    changed_.notify_all();
    return true;
  }
  void add(Frame frame) {
    std::unique_lock lock(mutex_);
    const auto begin = std::chrono::steady_clock::now();
    while (options_.sender_waits && frames_.size() >= options_.capacity && !stop_) changed_.wait_for(lock, wake_up);
    waited_s_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (frames_.size() >= options_.capacity) {
      frames_.pop_front();
      ++dropped_;
    }
    if (!has_begun_)  // the last sample at or before the first frame, and those after it
      while (imu_.size() > 1 && imu_[1].t_ns <= frame.t_ns) imu_.pop_front();
    has_begun_ = true;
    frames_.push_back(std::move(frame));
    changed_.notify_all();
  }
  /// No more comes; `error` is thrown once all before it is taken.
  void end(std::exception_ptr error) {
    const std::lock_guard lock(mutex_);
    is_over_ = true;
    error_ = std::move(error);
    changed_.notify_all();
  }

  /// Waits for what comes next, nothing at the end or after `stop`. A frame does not wait for IMU samples once
  /// `capacity` frames are there. `time_offset_s` is the estimated correction of the time offset.
  std::optional<Sample> next(double time_offset_s) {
    std::unique_lock lock(mutex_);
    const plumbline::TimeNs offset_ns = std::llround(1e9 * time_offset_s);
    while (!has_next(offset_ns) && !stop_) changed_.wait_for(lock, wake_up);
    if (stop_) return std::nullopt;
    if (frames_.empty()) {
      if (error_) std::rethrow_exception(error_);
      return std::nullopt;
    }
    const bool is_reached = given_ns_ && *given_ns_ >= frames_.front().t_ns + offset_ns;
    if (options_.with_imu && !is_reached && !imu_.empty()) {
      const plumbline::ImuSample sample = imu_.front();
      imu_.pop_front();
      given_ns_ = sample.t_ns;
      return sample;
    }
    std::optional<Sample> out(std::in_place, std::move(frames_.front()));
    frames_.pop_front();
    changed_.notify_all();
    return out;
  }

  std::size_t waiting() const {
    const std::lock_guard lock(mutex_);
    return frames_.size();
  }
  std::size_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }
  /// How long the thread that receives has waited [s].
  double sender_waited_s() const {
    const std::lock_guard lock(mutex_);
    return waited_s_;
  }

 private:
  static constexpr std::chrono::milliseconds wake_up{100};  ///< of those who wait, to see `stop`

  bool has_next(plumbline::TimeNs offset_ns) const {
    if (is_over_) return true;
    if (frames_.empty()) return false;
    const bool is_reached = given_ns_ && *given_ns_ >= frames_.front().t_ns + offset_ns;
    return !options_.with_imu || is_reached || !imu_.empty() || frames_.size() >= options_.capacity;
  }

  Options options_;
  const std::atomic<bool>& stop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<plumbline::ImuSample> imu_;
  std::deque<Frame> frames_;
  std::optional<plumbline::TimeNs> given_ns_;  ///< the latest IMU sample that was taken
  bool is_over_ = false, has_begun_ = false;   ///< a frame has come
  std::exception_ptr error_;
  std::size_t dropped_ = 0;
  double waited_s_ = 0;
};
