#include "live_queue.hpp"

#include <chrono>
#include <cmath>
#include <utility>

namespace pl = plumbline;

using namespace std::chrono_literals;  // condition variables wake up now and then, to see `stop`

bool LiveQueue::add(const pl::ImuSample& sample) {
  const std::lock_guard lock(mutex_);
  if (imu_.size() == most_imu) return false;
  imu_.push_back(sample);
  changed_.notify_all();
  return true;
}

void LiveQueue::add(LiveFrame frame) {
  std::unique_lock lock(mutex_);
  const auto begin = std::chrono::steady_clock::now();
  while (options_.sender_waits && frames_.size() >= options_.capacity && !stop_) changed_.wait_for(lock, 100ms);
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

void LiveQueue::end(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  is_over_ = true;
  error_ = std::move(error);
  changed_.notify_all();
}

bool LiveQueue::has_next(pl::TimeNs offset_ns) const {
  if (is_over_) return true;
  if (frames_.empty()) return false;
  const bool is_reached = given_ns_ && *given_ns_ >= frames_.front().t_ns + offset_ns;
  return !options_.with_imu || is_reached || !imu_.empty() || frames_.size() >= options_.capacity;
}

std::optional<LiveSample> LiveQueue::next(double time_offset_s) {
  std::unique_lock lock(mutex_);
  const pl::TimeNs offset_ns = std::llround(1e9 * time_offset_s);
  while (!has_next(offset_ns) && !stop_) changed_.wait_for(lock, 100ms);
  if (stop_) return std::nullopt;
  if (frames_.empty()) {
    if (error_) std::rethrow_exception(error_);
    return std::nullopt;
  }
  const bool is_reached = given_ns_ && *given_ns_ >= frames_.front().t_ns + offset_ns;
  if (options_.with_imu && !is_reached && !imu_.empty()) {
    const pl::ImuSample sample = imu_.front();
    imu_.pop_front();
    given_ns_ = sample.t_ns;
    return sample;
  }
  std::optional<LiveSample> out(std::in_place, std::move(frames_.front()));
  frames_.pop_front();
  changed_.notify_all();
  return out;
}

std::size_t LiveQueue::waiting() const {
  const std::lock_guard lock(mutex_);
  return frames_.size();
}
std::size_t LiveQueue::dropped() const {
  const std::lock_guard lock(mutex_);
  return dropped_;
}
double LiveQueue::sender_waited_s() const {
  const std::lock_guard lock(mutex_);
  return waited_s_;
}
