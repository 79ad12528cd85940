#pragma once
/// Images with their depth images, which come on a topic of their own and in any order. An image waits for a depth
/// image whose time stamp differs by the tolerance at most.

#include <cstddef>
#include <cstdlib>
#include <deque>
#include <optional>
#include <utility>

#include "plumbline/core/time.hpp"
#include "plumbline_ros2/conversions.hpp"

namespace plumbline::ros2 {

class DepthPairing {
 public:
  using Pair = std::pair<HeldImage, HeldImage>;    // gray, depth
  static constexpr std::size_t most_waiting = 16;  ///< images, and depth images; then the oldest one is dropped

  explicit DepthPairing(TimeNs tolerance_ns) : tolerance_ns_(tolerance_ns) {}

  /// A pair, where this was the missing part of one. Images before it that wait are dropped.
  std::optional<Pair> add_gray(HeldImage gray) { return add(std::move(gray), gray_, depth_, true); }
  std::optional<Pair> add_depth(HeldImage depth) { return add(std::move(depth), depth_, gray_, false); }

  /// Images that were dropped because no depth image fits.
  std::size_t dropped() const { return dropped_; }

 private:
  std::optional<Pair> add(HeldImage image, std::deque<HeldImage>& own, std::deque<HeldImage>& other, bool is_gray) {
    const TimeNs t_ns = image.image.t_ns;
    auto nearest = other.end();
    TimeNs difference = tolerance_ns_;
    for (auto it = other.begin(); it != other.end(); ++it)
      if (const TimeNs d = std::abs(it->image.t_ns - t_ns); d <= difference) {
        nearest = it;
        difference = d;
      }
    if (nearest == other.end()) {
      own.push_back(std::move(image));
      if (own.size() > most_waiting) {
        own.pop_front();
        dropped_ += is_gray;
      }
      return std::nullopt;
    }
    HeldImage partner = std::move(*nearest);
    if (!is_gray) dropped_ += static_cast<std::size_t>(nearest - other.begin());
    other.erase(other.begin(), nearest + 1);
    while (!own.empty() && own.front().image.t_ns < t_ns) {
      own.pop_front();
      dropped_ += is_gray;
    }
    return is_gray ? Pair(std::move(image), std::move(partner)) : Pair(std::move(partner), std::move(image));
  }

  TimeNs tolerance_ns_;
  std::deque<HeldImage> gray_, depth_;
  std::size_t dropped_ = 0;
};

}  // namespace plumbline::ros2
