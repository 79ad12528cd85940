#pragma once
/// Keyframes in order of their ids, each of which stays in its slot: what refers to slots need not know of removals.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <class Keyframe, int MaxKeyframes>
class KeyframeSlots {
 public:
  static constexpr int none = -1;

  KeyframeSlots() {
    for (int slot = 0; slot < MaxKeyframes; ++slot) order_[std::size_t(slot)] = std::int16_t(slot);
  }

  int size() const { return size_; }
  bool full() const { return size_ == MaxKeyframes; }
  /// Of the k-th one.
  int slot(int k) const { return order_[std::size_t(k)]; }
  const Keyframe& operator[](int k) const { return keyframes_[std::size_t(slot(k))]; }
  Keyframe& operator[](int k) { return keyframes_[std::size_t(slot(k))]; }
  const Keyframe& in_slot(int slot) const { return keyframes_[std::size_t(slot)]; }
  Keyframe& in_slot(int slot) { return keyframes_[std::size_t(slot)]; }
  /// Place in the order of the keyframe with that id, `none` of others.
  int find(std::uint32_t id) const {
    for (int k = size_ - 1; k >= 0 && (*this)[k].id >= id; --k) {
      if ((*this)[k].id == id) return k;
    }
    return none;
  }

  /// The keyframe [size()], filled in before, becomes the last one.
  void append() {
    PLUMBLINE_ASSERT(!full());
    ++size_;
  }
  /// Removes the k-th one; those after it move up by one.
  void remove(int k) {
    PLUMBLINE_ASSERT(k >= 0 && k < size_);
    std::rotate(order_.begin() + k, order_.begin() + k + 1, order_.begin() + size_);
    --size_;
  }
  void clear() { size_ = 0; }

 private:
  int size_ = 0;
  std::array<std::int16_t, std::size_t(MaxKeyframes)> order_;
  std::array<Keyframe, std::size_t(MaxKeyframes)> keyframes_;
};

}  // namespace plumbline
