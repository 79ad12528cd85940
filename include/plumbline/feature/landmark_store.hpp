#pragma once
/// The landmarks of one kind that an estimator knows: kept, counted and forgotten, whatever they are. Finding them in
/// images is the front end's; what they say about the frames, the terms'.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/feature_kind.hpp"
#include "plumbline/feature/landmark.hpp"

namespace plumbline {

/// How long landmarks are remembered.
struct StoreOptions {
  int max_misses = 30;       ///< frames in a row that look for a landmark in vain before it is forgotten
  int min_observations = 2;  ///< frames that saw a landmark that is kept although it is out of sight: it ties them
};

template <FeatureKind KindT, int CapacityT, int Slots>
class LandmarkStore {
 public:
  using Kind = KindT;
  using S = typename Kind::Scalar;
  using Landmark = plumbline::Landmark<Kind, Slots>;
  using Landmarks = FixedVector<Landmark, CapacityT>;
  static constexpr int capacity = CapacityT, slots = Slots;

  /// Of the latest frame: seen there, but not where its pose has it.
  struct Rejected {
    std::uint32_t id;
    typename Kind::Place place;
  };

  explicit LandmarkStore(const StoreOptions& options) : options_(options) {}

  const Landmarks& landmarks() const { return landmarks_; }
  Landmarks& landmarks() { return landmarks_; }
  const FixedVector<Rejected, CapacityT>& rejected() const { return rejected_; }

  /// Seen by the latest frame.
  int seen_count() const {
    int n = 0;
    for (const Landmark& landmark : landmarks_) n += landmark.current.valid;
    return n;
  }
  /// Those of them that are located.
  int tracked_count() const {
    int n = 0;
    for (const Landmark& landmark : landmarks_) n += landmark.current.valid && landmark.located;
    return n;
  }

  /// A new frame: what was current is now previous.
  void begin_frame() {
    rejected_.clear();
    for (Landmark& landmark : landmarks_) landmark.previous = landmark.current;
  }
  /// Back to what the frame before saw, for a frame that could not be used.
  void undo_frame() {
    for (Landmark& landmark : landmarks_) landmark.current = landmark.previous;
  }
  /// Whatever the latest frame took for them, it sees none of them.
  void lose_sight() {
    for (Landmark& landmark : landmarks_) landmark.current.valid = false;
  }
  /// The latest frame does not see this landmark after all.
  void reject(int index) {
    Landmark& landmark = landmarks_[static_cast<std::size_t>(index)];
    landmark.current.valid = false;
    rejected_.push_back({landmark.id, landmark.current.place()});
  }
  /// Records what the latest frame saw as observations of the frame in `slot`.
  void record(int slot) {
    for (Landmark& landmark : landmarks_) landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
  }

  /// A landmark first seen by the frame in `slot`; an id of its own. False when there is no room: all others are in
  /// sight.
  bool add(Landmark& landmark, int slot) {
    if (!make_room()) return false;
    landmark.id = next_id_++;
    landmark.anchor = slot;
    landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
    landmarks_.push_back(landmark);
    return true;
  }

  /// Forgets the frame in `slot` and every landmark that is anchored there.
  void remove_frame(int slot) {
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      landmarks_[i].observations[static_cast<std::size_t>(slot)].valid = false;
      if (landmarks_[i].anchor == slot) landmarks_.swap_remove(i);
    }
  }
  /// Forgets landmarks that cannot be of use any more.
  void prune() {
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      const Landmark& landmark = landmarks_[i];
      if (landmark.current.valid) continue;
      const bool unproven = !landmark.located || landmark.observation_count() < options_.min_observations;
      if (unproven || landmark.misses > options_.max_misses) landmarks_.swap_remove(i);
    }
  }
  void clear() { landmarks_.clear(); }

  /// The readout time of all images turned out to be `change_s` longer than thought.
  void change_readout(S change_s) {
    for (Landmark& landmark : landmarks_) {
      Kind::change_readout(landmark.geometry, landmark.seen_by_anchor(), change_s);
      landmark.current.change_readout(change_s);
      for (auto& seen : landmark.observations) seen.change_readout(change_s);
    }
  }
  /// All lengths become `scale` times what they were.
  void rescale(S scale) {
    for (Landmark& landmark : landmarks_) {
      Kind::rescale(landmark.geometry, scale);
      landmark.current.rescale(scale);
      for (auto& seen : landmark.observations) seen.rescale(scale);
    }
  }

  /// Adds up how far the landmarks in sight moved since the frame in `slot`, if they moved less than `below` [px].
  void add_motion_since(int slot, double below, double& sum_px, int& count) const {
    for (const Landmark& landmark : landmarks_) {
      const auto& then = landmark.observations[static_cast<std::size_t>(slot)];
      if (!landmark.current.valid || !then.valid) continue;
      const double px = Kind::motion_px(then, landmark.current);
      if (!(px < below)) continue;
      sum_px += px;
      ++count;
    }
  }
  /// Adds up the inverse ranges of the landmarks in sight, from their anchors [1/m].
  void add_inverse_ranges(S& sum, int& count) const {
    for (const Landmark& landmark : landmarks_) {
      if (!landmark.current.valid || !landmark.located) continue;
      sum += Kind::inverse_range(landmark.geometry);
      ++count;
    }
  }

 private:
  /// Where all places are taken, the landmark out of sight that was looked for in vain most often goes, of equals the
  /// oldest. False when all are in sight.
  bool make_room() {
    if (!landmarks_.full()) return true;
    const auto worst = std::max_element(landmarks_.begin(), landmarks_.end(), [](const Landmark& a, const Landmark& b) {
      if (a.current.valid != b.current.valid) return a.current.valid;
      return a.misses != b.misses ? a.misses < b.misses : a.id > b.id;
    });
    if (worst->current.valid) return false;
    landmarks_.swap_remove(static_cast<std::size_t>(worst - landmarks_.begin()));
    return true;
  }

  StoreOptions options_;
  Landmarks landmarks_;
  FixedVector<Rejected, CapacityT> rejected_;
  std::uint32_t next_id_ = 0;
};

}  // namespace plumbline
