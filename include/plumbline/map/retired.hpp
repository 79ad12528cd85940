#pragma once
/// A retired frame, as a backend hands it to the map: the frame, the landmarks anchored in it, its observations and the
/// appearance of its landmarks. All of it is valid during the call only; the map copies what it keeps.

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
  const State x;  ///< last estimate

  /// visit(landmark, observation): all located landmarks anchored in the frame, in coordinates of its camera, with the
  /// observation by the frame. A Landmark has its kind, `Landmark::Kind`, id, covariance and appearance.
  void for_each_landmark(auto&& visit) const {
    landmarks_.for_each([&](const auto& store) {
      for (const auto& landmark : store.landmarks()) {
        if (landmark.anchor == slot_ && landmark.located) visit(landmark, landmark.seen_by_anchor());
      }
    });
  }
  /// visit(id, observation): the frame's observations of landmarks anchored in other frames.
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
