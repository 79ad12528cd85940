#pragma once
/// Binary search tree of descriptors that grows with what is added: an inner node tests one bit, a leaf holds up to
/// LeafSize entries.                                                              docs/math/place_recognition.md
///
///   leaf(x):  from the root on, at a node with bit k take child x_k                                             (8)
///   a full leaf is split by the bit with the most even halves, argmin_k |2 ones_k - n|,                         (9)
///   among those with at least n/8 entries on each side; two sibling leaves with LeafSize/2 entries or fewer
///   are merged
/// Descriptors themselves are stored elsewhere; an entry is a number that stands for one. Depth is at most the number
/// of bits tested, work per call is bounded, and leaves that became empty are used again.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/assert.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

template <std::size_t MaxEntries, std::size_t LeafSize>
class HammingTree {
  static_assert(LeafSize >= 16, "plumbline: a leaf holds at least 16 entries, so that its halves can be told apart");

 public:
  using Entry = std::uint32_t;
  static constexpr std::size_t max_leaves = 2 * (MaxEntries / LeafSize + 1);

  HammingTree() { clear(); }

  /// Empties the tree, which from now on tests bits first_bit, first_bit + bit_step, ...
  void test_bits(int first_bit, int bit_step) {
    PLUMBLINE_ASSERT(first_bit >= 0 && bit_step >= 1 && first_bit < BinaryDescriptor::bits);
    first_bit_ = first_bit;
    bit_step_ = bit_step;
    clear();
  }

  void clear() {
    nodes_[root] = {.parent = none, .first_child = none, .bit = leaf_bit, .leaf = 0};
    sizes_[0] = 0;
    pairs_used_ = 0;
    leaves_used_ = 1;
    free_pair_ = free_leaf_ = none;
  }

  /// The entries of leaf(x).                                                                                     (8)
  std::span<const Entry> find(const BinaryDescriptor& x) const {
    const std::size_t leaf = static_cast<std::size_t>(nodes_[node_of(x)].leaf);
    return {entries_[leaf].data(), sizes_[leaf]};
  }

  /// Adds the entry of descriptor x; `descriptor_of(entry)` gives those of the others. False, and nothing added, when
  /// the leaf is full and cannot be split: its descriptors are too much alike, or no leaf is free.
  bool add(Entry entry, const BinaryDescriptor& x, auto&& descriptor_of) {
    std::size_t node = node_of(x);
    if (sizes_[static_cast<std::size_t>(nodes_[node].leaf)] == LeafSize) {
      if (!split(node, descriptor_of)) return false;
      node = child_of(node, x);
    }
    const std::size_t leaf = static_cast<std::size_t>(nodes_[node].leaf);
    entries_[leaf][sizes_[leaf]++] = entry;
    return true;
  }

  /// Removes the entry of descriptor x. False when it is not there.
  bool remove(Entry entry, const BinaryDescriptor& x) {
    const std::size_t node = node_of(x), leaf = static_cast<std::size_t>(nodes_[node].leaf);
    for (std::size_t i = 0; i < sizes_[leaf]; ++i) {
      if (entries_[leaf][i] != entry) continue;
      entries_[leaf][i] = entries_[leaf][--sizes_[leaf]];
      for (std::int32_t up = nodes_[node].parent; up != none; up = nodes_[static_cast<std::size_t>(up)].parent) {
        if (!merge(static_cast<std::size_t>(up))) break;
      }
      return true;
    }
    return false;
  }

  /// Leaves in use, of `max_leaves`.
  std::size_t leaves() const {
    std::size_t unused = 0;
    for (std::int32_t leaf = free_leaf_; leaf != none; leaf = next_free_[static_cast<std::size_t>(leaf)]) ++unused;
    return leaves_used_ - unused;
  }

 private:
  static constexpr std::int32_t none = -1;
  static constexpr std::int16_t leaf_bit = -1;
  static constexpr std::size_t root = 0;

  struct Node {
    std::int32_t parent;
    std::int32_t first_child;  ///< the other one follows it
    std::int16_t bit;          ///< tested; `leaf_bit`: a leaf
    std::int32_t leaf;
  };

  std::size_t child_of(std::size_t node, const BinaryDescriptor& x) const {
    return static_cast<std::size_t>(nodes_[node].first_child + x.bit(nodes_[node].bit));
  }
  std::size_t node_of(const BinaryDescriptor& x) const {
    std::size_t node = root;
    while (nodes_[node].bit != leaf_bit) node = child_of(node, x);
    return node;
  }
  /// (9). `leaf_bit` when no bit has halves that are even enough.
  std::int16_t best_bit(std::size_t leaf, auto&& descriptor_of) const {
    std::array<std::uint16_t, BinaryDescriptor::bits> ones{};
    for (std::size_t i = 0; i < sizes_[leaf]; ++i) {
      const BinaryDescriptor& x = descriptor_of(entries_[leaf][i]);
      for (int bit = first_bit_; bit < BinaryDescriptor::bits; bit += bit_step_) {
        ones[static_cast<std::size_t>(bit)] =
            static_cast<std::uint16_t>(ones[static_cast<std::size_t>(bit)] + x.bit(bit));
      }
    }
    const int n = static_cast<int>(sizes_[leaf]);
    int best_excess = n - n / 4 + 1;  // halves of n/8 and 7n/8 have an excess of 3n/4
    std::int16_t best = leaf_bit;
    for (int bit = first_bit_; bit < BinaryDescriptor::bits; bit += bit_step_) {
      const int difference = 2 * ones[static_cast<std::size_t>(bit)] - n,
                excess = difference < 0 ? -difference : difference;
      if (excess >= best_excess) continue;
      best_excess = excess;
      best = static_cast<std::int16_t>(bit);
    }
    return best;
  }

  bool split(std::size_t node, auto&& descriptor_of) {
    const std::size_t leaf = static_cast<std::size_t>(nodes_[node].leaf);
    if (free_leaf_ == none && leaves_used_ == max_leaves) return false;
    const std::int16_t bit = best_bit(leaf, descriptor_of);
    if (bit == leaf_bit) return false;
    const std::size_t other = take(free_leaf_, leaves_used_, next_free_);
    const std::size_t first = 1 + 2 * take(free_pair_, pairs_used_, next_free_pair_);
    nodes_[node].bit = bit;
    nodes_[node].first_child = static_cast<std::int32_t>(first);
    nodes_[first] = {static_cast<std::int32_t>(node), none, leaf_bit, static_cast<std::int32_t>(leaf)};
    nodes_[first + 1] = {static_cast<std::int32_t>(node), none, leaf_bit, static_cast<std::int32_t>(other)};
    std::uint16_t kept = 0, moved = 0;
    for (std::size_t i = 0; i < sizes_[leaf]; ++i) {
      const Entry entry = entries_[leaf][i];
      if (descriptor_of(entry).bit(bit)) {
        entries_[other][moved++] = entry;
      } else {
        entries_[leaf][kept++] = entry;
      }
    }
    sizes_[leaf] = kept;
    sizes_[other] = moved;
    return true;
  }

  /// The node becomes a leaf when both children are leaves that have few entries.
  bool merge(std::size_t node) {
    const std::size_t first = static_cast<std::size_t>(nodes_[node].first_child);
    if (nodes_[first].bit != leaf_bit || nodes_[first + 1].bit != leaf_bit) return false;
    const std::size_t a = static_cast<std::size_t>(nodes_[first].leaf);
    const std::size_t b = static_cast<std::size_t>(nodes_[first + 1].leaf);
    if (sizes_[a] + sizes_[b] > LeafSize / 2) return false;
    for (std::size_t i = 0; i < sizes_[b]; ++i) entries_[a][sizes_[a]++] = entries_[b][i];
    nodes_[node].bit = leaf_bit;
    nodes_[node].leaf = static_cast<std::int32_t>(a);
    give(b, free_leaf_, next_free_);
    give((first - 1) / 2, free_pair_, next_free_pair_);
    return true;
  }

  /// Lists of what is free: those given back, then those never used.
  template <std::size_t N>
  static std::size_t take(std::int32_t& free, std::size_t& used, const std::array<std::int32_t, N>& next) {
    if (free == none) return used++;
    const std::size_t taken = static_cast<std::size_t>(free);
    free = next[taken];
    return taken;
  }
  template <std::size_t N>
  static void give(std::size_t item, std::int32_t& free, std::array<std::int32_t, N>& next) {
    next[item] = free;
    free = static_cast<std::int32_t>(item);
  }

  int first_bit_ = 0, bit_step_ = 1;
  std::array<Node, 2 * max_leaves - 1> nodes_;
  std::array<std::array<Entry, LeafSize>, max_leaves> entries_;
  std::array<std::uint16_t, max_leaves> sizes_;
  std::array<std::int32_t, max_leaves> next_free_;           ///< of leaves
  std::array<std::int32_t, max_leaves - 1> next_free_pair_;  ///< of pairs of nodes: pair i is nodes 1 + 2 i, 2 + 2 i
  std::size_t pairs_used_ = 0, leaves_used_ = 0;
  std::int32_t free_pair_ = none, free_leaf_ = none;
};

}  // namespace plumbline
