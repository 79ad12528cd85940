#pragma once
/// Store of the landmarks of one kind: insertion, removal, counts, and operations on all of them. The front end finds
/// them in images; the terms compute their rows.

#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/feature_kind.hpp"
#include "plumbline/feature/landmark.hpp"

namespace plumbline {

/// When landmarks out of view are removed.
struct StoreOptions {
  /// Frames in a row without finding a landmark after which it is removed; frame rate: one second at 30 Hz.
  int max_misses = 30;
  /// Observations below which a landmark out of view is removed; others constrain the frames;
  /// geometry: one view constrains no two frames.
  int min_observations = 2;
};

template <FeatureKind KindT, int CapacityT, int Slots>
class LandmarkStore {
 public:
  using Kind = KindT;
  using S = typename Kind::Scalar;
  using Landmark = plumbline::Landmark<Kind, Slots>;
  using Landmarks = FixedVector<Landmark, CapacityT>;
  static constexpr int capacity = CapacityT, slots = Slots;

  /// An observation of the latest frame that was rejected as an outlier.
  struct Rejected {
    std::uint32_t id;
    typename Kind::Place place;
  };

  explicit LandmarkStore(const StoreOptions& options) : options_(options) {}

  const Landmarks& landmarks() const { return landmarks_; }
  Landmarks& landmarks() { return landmarks_; }
  const FixedVector<Rejected, CapacityT>& rejected() const { return rejected_; }

  /// Number of landmarks observed by the latest frame.
  int seen_count() const {
    int n = 0;
    for (const Landmark& landmark : landmarks_) n += landmark.current.valid;
    return n;
  }
  /// Number of the located ones among them.
  int tracked_count() const {
    int n = 0;
    for (const Landmark& landmark : landmarks_) n += landmark.current.valid && landmark.located;
    return n;
  }

  /// Begins a new frame: current observations become previous ones.
  void begin_frame() {
    rejected_.clear();
    for (Landmark& landmark : landmarks_) landmark.previous = landmark.current;
  }
  /// Restores the observations of the frame before, for a frame that could not be used.
  void undo_frame() {
    for (Landmark& landmark : landmarks_) landmark.current = landmark.previous;
  }
  /// Discards all observations of the latest frame.
  void clear_current() {
    for (Landmark& landmark : landmarks_) landmark.current.valid = false;
  }
  /// Rejects the observation of a landmark by the latest frame.
  void reject(int index) {
    Landmark& landmark = landmarks_[static_cast<std::size_t>(index)];
    landmark.current.valid = false;
    rejected_.push_back({landmark.id, landmark.current.place()});
  }
  /// Copies the observations of the latest frame to the frame in `slot`.
  void record(int slot) {
    for (Landmark& landmark : landmarks_) landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
  }

  /// Adds a landmark first observed by the frame in `slot`, its anchor, and gives it a new id. False when the store is
  /// full and all landmarks are in view.
  bool add(Landmark& landmark, int slot) {
    if (!make_room()) return false;
    landmark.id = next_id_++;
    landmark.anchor = slot;
    landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
    landmarks_.push_back(landmark);
    return true;
  }

  /// Removes the observations of the frame in `slot`, and every landmark that is anchored there.
  void remove_frame(int slot) {
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      landmarks_[i].observations[static_cast<std::size_t>(slot)].valid = false;
      if (landmarks_[i].anchor == slot) landmarks_.swap_remove(i);
    }
  }
  /// Removes landmarks out of view by the rules of StoreOptions, and those that are not located.
  void prune() {
    for (std::size_t i = landmarks_.size(); i-- > 0;) {
      const Landmark& landmark = landmarks_[i];
      if (landmark.current.valid) continue;
      const bool unproven = !landmark.located || landmark.observation_count() < options_.min_observations;
      if (unproven || landmark.misses > options_.max_misses) landmarks_.swap_remove(i);
    }
  }
  void clear() { landmarks_.clear(); }

  /// Corrects all observations for a readout time that is `change_s` longer.
  void change_readout(S change_s) {
    for (Landmark& landmark : landmarks_) {
      Kind::change_readout(landmark.geometry, landmark.seen_by_anchor(), change_s);
      landmark.current.change_readout(change_s);
      for (auto& seen : landmark.observations) seen.change_readout(change_s);
    }
  }
  /// Multiplies all lengths by `scale`.
  void rescale(S scale) {
    for (Landmark& landmark : landmarks_) {
      Kind::rescale(landmark.geometry, scale);
      landmark.current.rescale(scale);
      for (auto& seen : landmark.observations) seen.rescale(scale);
    }
  }

  /// Sums the motion of the landmarks in view since the frame in `slot`, if it is less than `below` [px].
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
  /// Sums the inverse ranges, from their anchors, of the tracked landmarks [1/m].
  void add_inverse_ranges(S& sum, int& count) const {
    for (const Landmark& landmark : landmarks_) {
      if (!landmark.current.valid || !landmark.located) continue;
      sum += Kind::inverse_range(landmark.geometry);
      ++count;
    }
  }

 private:
  /// Makes room in a full store: removes the landmark out of view with most misses, of equals the oldest. False when
  /// all are in view.
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
