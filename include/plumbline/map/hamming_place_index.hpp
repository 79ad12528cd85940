#pragma once
/// Place index by multi-index search of binary descriptors: a forest of Hamming trees that grows with the run. No
/// vocabulary is trained beforehand.                                               docs/math/place_recognition.md
///
///   tree t of T tests the bits k with k mod T = t                                                               (10)
///   d_ik = smallest d(x_i, y) over y of keyframe k in the leaves of x_i in all trees                           (11)
///   s_k  = 1/M sum_i w_i max(0, 1 - d_ik / (d_max + 1))^2,   w_i = (log((K + 1) / n_i) / log max(K + 1, 50))^2  (12)
///          n_i = number of keyframes with d_ik <= d_max, K = number of keyframes asked, M = size of the query
/// The trees test disjoint bits: noise that turns one of them loses the descriptor in one tree only. A descriptor that
/// many keyframes have says little about the place: w_i is the inverse document frequency of query and keyframe. Below
/// 50 keyframes it is not known well, and scores are lower.
///
/// Work of a query: at most Trees * LeafSize distances a descriptor, whatever the number of keyframes, and one pass
/// over these. Memory: 32 bytes a descriptor and 9 bytes a descriptor and tree, 10 MB for 500 keyframes of 300
/// descriptors; the object is meant to be static.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/map/hamming_tree.hpp"
#include "plumbline/map/place_index.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

template <std::size_t MaxKeyframes, std::size_t MaxDescriptors, std::size_t Trees = 4, std::size_t LeafSize = 64>
class HammingPlaceIndex {
  static_assert(Trees >= 1 && Trees <= 16, "plumbline: 1 to 16 trees, so that each has bits enough to test");
  static_assert(MaxKeyframes * MaxDescriptors < 0x7FFFFFFF, "plumbline: entries are numbered by 31 bits");

 public:
  static constexpr std::size_t max_keyframes = MaxKeyframes, max_descriptors = MaxDescriptors;
  static constexpr int max_distance = 30;  ///< d_max [bits]
  static constexpr float full_weight_keyframes = 50;

  HammingPlaceIndex() {
    for (std::size_t t = 0; t < Trees; ++t) trees_[t].test_bits(static_cast<int>(t), static_cast<int>(Trees));  // (10)
  }

  void clear() {
    for (Tree& tree : trees_) tree.clear();
    counts_.fill(0);
    used_.fill(false);
    size_ = 0;
  }

  std::size_t size() const { return size_; }
  bool contains(std::uint32_t id) const { return slot_of(id) != MaxKeyframes; }
  /// Of that keyframe, empty when it is not there. Valid until the next call of add, remove or clear.
  std::span<const BinaryDescriptor> descriptors(std::uint32_t id) const {
    const std::size_t slot = slot_of(id);
    if (slot == MaxKeyframes) return {};
    return {descriptors_.data() + slot * MaxDescriptors, counts_[slot]};
  }

  bool add(std::uint32_t id, std::span<const BinaryDescriptor> seen) {
    if (size_ == MaxKeyframes || contains(id)) return false;
    const std::size_t slot = static_cast<std::size_t>(std::find(used_.begin(), used_.end(), false) - used_.begin());
    ids_[slot] = id;
    used_[slot] = true;
    counts_[slot] = static_cast<std::uint32_t>(std::min(seen.size(), MaxDescriptors));
    ++size_;
    const std::size_t first = slot * MaxDescriptors;
    std::copy_n(seen.begin(), counts_[slot], descriptors_.begin() + static_cast<std::ptrdiff_t>(first));
    for (std::size_t i = first; i < first + counts_[slot]; ++i) {
      for (Tree& tree : trees_) {
        tree.add(static_cast<std::uint32_t>(i), descriptors_[i],
                 [&](std::uint32_t e) -> const BinaryDescriptor& { return descriptors_[e]; });
      }
    }
    return true;
  }

  bool remove(std::uint32_t id) {
    const std::size_t slot = slot_of(id);
    if (slot == MaxKeyframes) return false;
    const std::size_t first = slot * MaxDescriptors;
    for (std::size_t i = first; i < first + counts_[slot]; ++i) {
      for (Tree& tree : trees_) tree.remove(static_cast<std::uint32_t>(i), descriptors_[i]);
    }
    used_[slot] = false;
    counts_[slot] = 0;
    --size_;
    return true;
  }

  std::size_t query(std::span<const BinaryDescriptor> seen, std::span<PlaceCandidate> out) {
    return query(seen, out, [](std::uint32_t) { return true; });
  }
  template <class Accept>
  std::size_t query(std::span<const BinaryDescriptor> seen, std::span<PlaceCandidate> out, Accept&& accept) {
    std::size_t accepted = 0;
    for (std::size_t slot = 0; slot < MaxKeyframes; ++slot) {
      accepted_[slot] = used_[slot] && accept(ids_[slot]);
      accepted += accepted_[slot];
      scores_[slot] = 0;
      nearest_[slot] = not_near;
    }
    if (accepted == 0) return 0;
    const float keyframes = static_cast<float>(accepted + 1);
    const float idf_unit = 1.0f / std::log(std::max(keyframes, full_weight_keyframes));
    for (const BinaryDescriptor& x : seen) vote(x, keyframes, idf_unit);
    return best(1.0f / static_cast<float>(std::max<std::size_t>(seen.size(), 1)), out);
  }

 private:
  using Tree = HammingTree<MaxKeyframes * MaxDescriptors, LeafSize>;
  static constexpr std::uint16_t not_near = max_distance + 1;

  std::size_t slot_of(std::uint32_t id) const {
    for (std::size_t slot = 0; slot < MaxKeyframes; ++slot) {
      if (used_[slot] && ids_[slot] == id) return slot;
    }
    return MaxKeyframes;
  }

  /// The descriptors of a leaf lie all over the memory: they are asked for together before the first one is read.
  static void prefetch([[maybe_unused]] const BinaryDescriptor& descriptor) {
#if defined(__GNUC__)
    __builtin_prefetch(&descriptor);
#endif
  }

  /// Adds the terms of one descriptor to the scores.                                                      (11), (12)
  void vote(const BinaryDescriptor& x, float keyframes, float idf_unit) {
    std::size_t n = 0;
    for (const Tree& tree : trees_) {
      const std::span<const std::uint32_t> leaf = tree.find(x);
      for (const std::uint32_t entry : leaf) prefetch(descriptors_[entry]);
      for (const std::uint32_t entry : leaf) {
        const int d = hamming_distance(x, descriptors_[entry], max_distance);
        const std::size_t slot = entry / MaxDescriptors;
        if (d >= nearest_[slot] || !accepted_[slot]) continue;
        if (nearest_[slot] == not_near) near_slots_[n++] = static_cast<std::uint32_t>(slot);
        nearest_[slot] = static_cast<std::uint16_t>(d);
      }
    }
    if (n == 0) return;
    const float idf = idf_unit * std::log(keyframes / static_cast<float>(n));
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t slot = near_slots_[i];
      const float nearness = 1.0f - static_cast<float>(nearest_[slot]) / (max_distance + 1);
      scores_[slot] += idf * idf * nearness * nearness;
      nearest_[slot] = not_near;
    }
  }

  /// The best scores, by insertion into `out`.
  std::size_t best(float scale, std::span<PlaceCandidate> out) const {
    std::size_t found = 0;
    for (std::size_t slot = 0; slot < MaxKeyframes; ++slot) {
      const PlaceCandidate candidate{ids_[slot], scale * scores_[slot]};
      if (!(candidate.score > 0) || (found == out.size() && (found == 0 || candidate.score <= out.back().score)))
        continue;
      std::size_t i = found < out.size() ? found++ : found - 1;
      for (; i > 0 && out[i - 1].score < candidate.score; --i) out[i] = out[i - 1];
      out[i] = candidate;
    }
    return found;
  }

  std::array<BinaryDescriptor, MaxKeyframes * MaxDescriptors> descriptors_;
  std::array<Tree, Trees> trees_;
  std::array<std::uint32_t, MaxKeyframes> ids_{}, counts_{};
  std::array<bool, MaxKeyframes> used_{};
  std::size_t size_ = 0;
  // Of a query.
  std::array<bool, MaxKeyframes> accepted_{};
  std::array<float, MaxKeyframes> scores_{};
  std::array<std::uint16_t, MaxKeyframes> nearest_{};
  std::array<std::uint32_t, MaxKeyframes> near_slots_{};
};

static_assert(PlaceIndex<HammingPlaceIndex<2, 16>>);

}  // namespace plumbline
