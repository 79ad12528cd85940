#pragma once
/// The last `Capacity` items, oldest first; one more in a full buffer replaces the oldest.

#include <array>
#include <cstddef>
#include <utility>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <class T, std::size_t Capacity>
class RingBuffer {
  static_assert(Capacity > 0, "plumbline: a ring buffer needs room for one item");

 public:
  RingBuffer() {}  // not constexpr: compilers evaluate such a constructor item by item
  static constexpr std::size_t capacity() { return Capacity; }
  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == Capacity; }
  void clear() { size_ = 0; }

  void push_back(T value) {
    items_[index(size_)] = std::move(value);
    if (full()) {
      first_ = index(1);
    } else {
      ++size_;
    }
  }

  /// Before item i, or behind all of them for i = size(); a full buffer has no room before its oldest. Returns the
  /// index of the new item.
  std::size_t insert(std::size_t i, T value) {
    PLUMBLINE_ASSERT(i <= size_ && !(full() && i == 0));
    const std::size_t at = full() ? i - 1 : i;
    push_back(value);
    for (std::size_t k = size_ - 1; k > at; --k) (*this)[k] = std::move((*this)[k - 1]);
    (*this)[at] = std::move(value);
    return at;
  }

  void pop_front() {
    PLUMBLINE_ASSERT(size_ > 0);
    first_ = index(1);
    --size_;
  }

  /// Item i, 0 is the oldest.
  T& operator[](std::size_t i) {
    PLUMBLINE_ASSERT(i < size_);
    return items_[index(i)];
  }
  const T& operator[](std::size_t i) const {
    PLUMBLINE_ASSERT(i < size_);
    return items_[index(i)];
  }
  const T& front() const { return (*this)[0]; }
  const T& back() const { return (*this)[size_ - 1]; }

 private:
  std::size_t index(std::size_t i) const { return (first_ + i) % Capacity; }

  std::array<T, Capacity> items_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
};

}  // namespace plumbline
