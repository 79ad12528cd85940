#pragma once
/// A queue with one writer, an interrupt, and one reader, the main loop. Neither waits for the other.

#include <array>
#include <atomic>
#include <cstdint>

#include "plumbline/imu/sample.hpp"

template <std::uint32_t Capacity>
class ImuQueue {
  static_assert((Capacity & (Capacity - 1)) == 0, "a power of two: counters may overflow");

 public:
  /// Of the interrupt; false, and nothing kept, when the queue is full.
  bool push(const plumbline::ImuSample& sample) {
    const std::uint32_t written = written_.load(std::memory_order_relaxed);
    if (written - read_.load(std::memory_order_acquire) == Capacity) return false;
    samples_[written % Capacity] = sample;
    written_.store(written + 1, std::memory_order_release);
    return true;
  }

  /// Of the main loop; false when the queue is empty.
  bool pop(plumbline::ImuSample& sample) {
    const std::uint32_t read = read_.load(std::memory_order_relaxed);
    if (read == written_.load(std::memory_order_acquire)) return false;
    sample = samples_[read % Capacity];
    read_.store(read + 1, std::memory_order_release);
    return true;
  }

 private:
  std::array<plumbline::ImuSample, Capacity> samples_;
  std::atomic<std::uint32_t> written_ = 0, read_ = 0;
};
