#pragma once
/// Samples on their way from the thread that reads the stream to the estimator, in the order in which a recording has
/// them: before a frame come the IMU samples up to its time and the first one at or after it.

#include <atomic>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <variant>

#include "plumbline/imu/sample.hpp"
#include "stream_message.hpp"

struct LiveFrame {
  plumbline::TimeNs stamp_ns;  ///< of the stream
  plumbline::TimeNs t_ns;      ///< for the estimator
  Message gray;
  std::optional<Message> depth;
};
using LiveSample = std::variant<plumbline::ImuSample, LiveFrame>;

class LiveQueue {
 public:
  struct Options {
    std::size_t capacity;  ///< frames that wait
    bool sender_waits;     ///< where they are more; else the oldest one is dropped
    bool with_imu;
  };
  static constexpr std::size_t most_imu = 1'000'000;  ///< samples that wait

  LiveQueue(const Options& options, const std::atomic<bool>& stop) : options_(options), stop_(stop) {}

  /// Of the thread that reads. False where more than `most_imu` samples wait for a frame.
  bool add(const plumbline::ImuSample& sample);
  void add(LiveFrame frame);
  /// No more comes; `error` is thrown once all before it is taken.
  void end(std::exception_ptr error);

  /// Waits for what comes next, nothing at the end or after `stop`. A frame does not wait for IMU samples once
  /// `capacity` frames are there. `time_offset_s` is the estimated correction of the time offset.
  std::optional<LiveSample> next(double time_offset_s);
  std::size_t waiting() const;
  std::size_t dropped() const;
  /// How long the thread that reads has waited [s].
  double sender_waited_s() const;

 private:
  bool has_next(plumbline::TimeNs offset_ns) const;

  Options options_;
  const std::atomic<bool>& stop_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<plumbline::ImuSample> imu_;
  std::deque<LiveFrame> frames_;
  std::optional<plumbline::TimeNs> given_ns_;  ///< the latest IMU sample that was taken
  bool is_over_ = false, has_begun_ = false;   ///< a frame has come
  std::exception_ptr error_;
  std::size_t dropped_ = 0;
  double waited_s_ = 0;
};
