#pragma once
/// What a backend hands to a map when a frame leaves it: the frame, the landmarks anchored in it, where they were seen
/// and how they look. All of it is values; the map copies what it wants to keep, nothing of it lives on.

#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class StateT, class Landmarks>
class Retired {
 public:
  using State = StateT;

  template <class Frame>
  Retired(int slot, const Frame& frame, const Landmarks& landmarks)
      : sequence(frame.sequence), t_ns(frame.t_ns), x(frame.state.value()), slot_(slot), landmarks_(landmarks) {}

  const std::uint32_t sequence;  ///< of the frame, counted from the first one
  const TimeNs t_ns;
  const State x;  ///< as it was estimated last

  /// visit(landmark, observation): all landmarks anchored in the frame, in its camera's coordinates, and where it saw
  /// them. A Landmark knows its kind, `Landmark::Kind`, its id, covariance and appearance.
  void for_each_landmark(auto&& visit) const {
    landmarks_.for_each([&](const auto& store) {
      for (const auto& landmark : store.landmarks()) {
        if (landmark.anchor == slot_ && landmark.located) visit(landmark, landmark.seen_by_anchor());
      }
    });
  }
  /// visit(id, observation): where the frame saw landmarks that stay with another one.
  void for_each_observation(auto&& visit) const {
    landmarks_.for_each([&](const auto& store) {
      for (const auto& landmark : store.landmarks()) {
        const auto& seen = landmark.observations[static_cast<std::size_t>(slot_)];
        if (landmark.anchor != slot_ && seen.valid) visit(landmark.id, seen);
      }
    });
  }

 private:
  int slot_;
  const Landmarks& landmarks_;
};

}  // namespace plumbline
