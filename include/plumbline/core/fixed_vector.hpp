#pragma once
/// A vector with its capacity in the type: no heap, ever. `push_back` on a full vector is refused, not undefined.

#include <array>
#include <cstddef>
#include <utility>

#include "plumbline/core/assert.hpp"

namespace plumbline {

template <class T, std::size_t Capacity>
class FixedVector {
 public:
  using value_type = T;
  FixedVector() {}  // not constexpr: compilers evaluate such a constructor item by item
  static constexpr std::size_t capacity() { return Capacity; }

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  bool full() const { return size_ == Capacity; }
  void clear() { size_ = 0; }

  /// Grows with default values or shrinks; at most to the capacity.
  void resize(std::size_t size) {
    PLUMBLINE_ASSERT(size <= Capacity);
    for (std::size_t i = size_; i < size; ++i) items_[i] = T{};
    size_ = size;
  }

  /// False, and nothing stored, when the vector is full.
  bool push_back(T value) {
    if (full()) return false;
    items_[size_++] = std::move(value);
    return true;
  }

  void pop_back() {
    PLUMBLINE_ASSERT(size_ > 0);
    --size_;
  }

  /// Removes item i by moving the last one into its place: O(1), order not kept.
  void swap_remove(std::size_t i) {
    PLUMBLINE_ASSERT(i < size_);
    if (i + 1 != size_) items_[i] = std::move(items_[size_ - 1]);
    --size_;
  }

  T& operator[](std::size_t i) {
    PLUMBLINE_ASSERT(i < size_);
    return items_[i];
  }
  const T& operator[](std::size_t i) const {
    PLUMBLINE_ASSERT(i < size_);
    return items_[i];
  }
  T& back() { return (*this)[size_ - 1]; }
  const T& back() const { return (*this)[size_ - 1]; }

  T* data() { return items_.data(); }
  const T* data() const { return items_.data(); }
  T* begin() { return items_.data(); }
  T* end() { return items_.data() + size_; }
  const T* begin() const { return items_.data(); }
  const T* end() const { return items_.data() + size_; }

 private:
  std::array<T, Capacity> items_;
  std::size_t size_ = 0;
};

}  // namespace plumbline
