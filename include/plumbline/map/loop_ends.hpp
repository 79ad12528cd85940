#pragma once
/// Order of elimination of a pose graph: nodes between loop ends first, then the loop ends.  docs/math/pose_graph.md
///
/// A loop end is a node that a loop touches, or the newest node; the first node is fixed and is none. The nodes between
/// two loop ends are eliminated along the sequence and leave one block between these two, so the loop ends are a small
/// graph of their own. They are eliminated by minimum degree, ties by sequence, the newest node last: its block of the
/// factor is its marginal information. `has_block(p, q)` says which blocks of that factor are not zero.

#include <algorithm>
#include <array>
#include <bitset>
#include <cstdint>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <int MaxNodes, int MaxLoops>
class LoopEnds {
 public:
  static constexpr int max_ends = std::min(2 * MaxLoops + 1, MaxNodes);
  static constexpr int none = -1;

  /// For `nodes` >= 2 nodes, and loops between the nodes `ends_of(l)` = {i, j}. Of order max_ends^2.
  template <class EndsOf>
  void find(int nodes, int loops, EndsOf&& ends_of) {
    PLUMBLINE_ASSERT(nodes >= 2 && nodes <= MaxNodes && loops >= 0 && loops <= MaxLoops);
    position_.fill(none);
    for (int l = 0; l < loops; ++l) {
      for (const int node : ends_of(l)) position_[std::size_t(node)] = 0;
    }
    position_[0] = none;
    position_[std::size_t(nodes - 1)] = 0;
    count_ = 0;
    for (int k = 1; k < nodes; ++k) {
      if (position_[std::size_t(k)] == none) continue;
      node_[std::size_t(count_)] = std::int16_t(k);
      position_[std::size_t(k)] = std::int16_t(count_++);  // of the sequence, until the order is found
    }
    connect(loops, ends_of);
    order();
  }

  int count() const { return count_; }
  bool is_end(int node) const { return position(node) != none; }
  /// Place of a loop end in the order, `none` of other nodes.
  int position(int node) const { return position_[std::size_t(node)]; }
  /// Whether block (p, q), q < p, of the factor over the loop ends is not zero.
  bool has_block(int p, int q) const { return rows_[std::size_t(p)][std::size_t(q)]; }

 private:
  using Set = std::bitset<std::size_t(max_ends)>;

  /// Neighbors by sequence, and by loops.
  template <class EndsOf>
  void connect(int loops, EndsOf&& ends_of) {
    for (int k = 0; k < count_; ++k) neighbors_[std::size_t(k)].reset();
    const auto add = [this](int a, int b) {
      if (a == none || b == none || a == b) return;
      neighbors_[std::size_t(a)].set(std::size_t(b));
      neighbors_[std::size_t(b)].set(std::size_t(a));
    };
    for (int k = 1; k < count_; ++k) add(k - 1, k);
    for (int l = 0; l < loops; ++l) {
      const std::array<int, 2> ends = ends_of(l);
      add(position(ends[0]), position(ends[1]));
    }
  }

  void order() {
    std::array<std::int16_t, std::size_t(max_ends)> place;
    Set left;
    for (int k = 0; k < count_; ++k) left.set(std::size_t(k));
    for (int p = 0; p < count_; ++p) {
      int best = count_ - 1;
      for (int k = 0; k + 1 < count_; ++k) {
        if (!left[std::size_t(k)]) continue;
        if (best == count_ - 1 || neighbors_[std::size_t(k)].count() < neighbors_[std::size_t(best)].count()) best = k;
      }
      left.reset(std::size_t(best));
      place[std::size_t(best)] = std::int16_t(p);
      const Set later = neighbors_[std::size_t(best)];  // all of them become neighbors of one another
      for (int k = 0; k < count_; ++k) {
        if (!later[std::size_t(k)]) continue;
        neighbors_[std::size_t(k)] |= later;
        neighbors_[std::size_t(k)].reset(std::size_t(k));
        neighbors_[std::size_t(k)].reset(std::size_t(best));
      }
    }
    for (int k = 0; k < count_; ++k) {
      rows_[std::size_t(place[std::size_t(k)])].reset();
      position_[std::size_t(node_[std::size_t(k)])] = place[std::size_t(k)];
    }
    for (int k = 0; k < count_; ++k) {  // of each one, those that were left when it was eliminated
      for (int later = 0; later < count_; ++later) {
        if (!neighbors_[std::size_t(k)][std::size_t(later)]) continue;
        rows_[std::size_t(place[std::size_t(later)])].set(std::size_t(place[std::size_t(k)]));
      }
    }
  }

  int count_ = 0;
  std::array<std::int16_t, std::size_t(MaxNodes)> position_{};
  std::array<std::int16_t, std::size_t(max_ends)> node_{};  ///< by sequence
  std::array<Set, std::size_t(max_ends)> neighbors_, rows_;
};

}  // namespace plumbline
