#pragma once
/// Candidates for a loop with one keyframe: the keyframes that look most like it, taken one by one.
///                                                                                docs/math/place_recognition.md
/// Between two of them keyframes may be removed: the keyframe that was asked for is known by its id, candidates by
/// their slots.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/map/place_index.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

template <class Places>
class LoopCandidates {
 public:
  static constexpr std::size_t capacity = 3;
  static constexpr int none = Places::none;

  /// Those of the index with a score of at least `min_score` that `accept(keyframe)` holds for, in order of their
  /// scores. Keyframe j has those descriptors.
  template <class Index>
  void query(Index& index, const Places& places, int j, std::span<const BinaryDescriptor> descriptors, float min_score,
             auto&& accept) {
    found_ =
        index.query(descriptors, candidates_, [&](std::uint32_t slot) { return accept(places.in_slot(int(slot))); });
    while (found_ > 0 && candidates_[found_ - 1].score < min_score) --found_;
    next_ = 0;
    asked_ = places.keyframe(j).id;
  }

  bool any() const { return found_ > 0; }
  bool all_taken() const { return next_ == found_; }
  /// Place in the order of the keyframe that was asked for; `none` where it was removed.
  int asked(const Places& places) const { return places.find(asked_); }
  /// Place of the next candidate; `none` where it is not before keyframe j.
  int take(const Places& places, int j) {
    const PlaceCandidate candidate = candidates_[next_++];
    int i = none;
    for (int k = 0; k < j; ++k) {
      if (places.slot(k) == int(candidate.id)) i = k;
    }
    return i;
  }

 private:
  std::array<PlaceCandidate, capacity> candidates_;
  std::size_t found_ = 0, next_ = 0;
  std::uint32_t asked_ = 0;
};

}  // namespace plumbline
