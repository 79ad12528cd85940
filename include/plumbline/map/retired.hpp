#pragma once
/// A retired frame, as a backend hands it to the map: the frame, the landmarks anchored in it, its observations and the
/// appearance of its landmarks. All of it is valid during the call only; the map copies what it keeps.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class StateT, class Landmarks>
class Retired {
 public:
  using State = StateT;

  using S = typename decltype(StateT::T_world_body)::Scalar;
  /// How certain the window is of T_i_j of the frames in slots i and j.
  struct RelativeCovariance {
    const void* window = nullptr;
    bool (*get)(const void* window, int i, int j, Mat<S, 6, 6>& covariance) = nullptr;
  };

  template <class Frames>
  Retired(int slot, const Frames& frames, const Landmarks& landmarks, const RelativeCovariance& relative = {})
      : sequence(frames[slot].sequence),
        t_ns(frames[slot].t_ns),
        x(frames[slot].state.value()),
        slot_(slot),
        landmarks_(landmarks),
        relative_(relative) {
    for (int k = 0; k < Frames::slots; ++k) {
      if (!frames[k].used || k == slot) continue;
      int& neighbor = frames[k].sequence < sequence ? before_ : after_;
      const bool is_nearer = neighbor < 0 || (k != neighbor && (frames[k].sequence < frames[neighbor].sequence) ==
                                                                   (frames[k].sequence > sequence));
      if (is_nearer) neighbor = k;
    }
    if (before_ >= 0) sequence_before_ = frames[before_].sequence;
    if (after_ >= 0) sequence_after_ = frames[after_].sequence;
  }

  const std::uint32_t sequence;  ///< of the frame, counted from the first one
  const TimeNs t_ns;
  const State x;  ///< last estimate

  /// visit(a, b, covariance): of the pose of frame b in frame a, both by sequence, a < b, right increment [rad, m];
  /// this frame with those before and after it in the window, as far as the window knows.
  void for_each_neighbor(auto&& visit) const {
    Mat<S, 6, 6> covariance;
    if (!relative_.get) return;
    if (before_ >= 0 && relative_.get(relative_.window, before_, slot_, covariance))
      visit(sequence_before_, sequence, covariance);
    if (after_ >= 0 && relative_.get(relative_.window, slot_, after_, covariance))
      visit(sequence, sequence_after_, covariance);
  }
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
  int slot_, before_ = -1, after_ = -1;  ///< slots
  std::uint32_t sequence_before_ = 0, sequence_after_ = 0;
  const Landmarks& landmarks_;
  RelativeCovariance relative_;
};

}  // namespace plumbline
