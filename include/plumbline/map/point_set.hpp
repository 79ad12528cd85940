#pragma once
/// A set of points of the map, by number; how many of them a keyframe sees is its covisibility.   docs/math/map.md 5

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/map/place_keyframe.hpp"

namespace plumbline {

template <std::size_t Capacity>
class PointSet {
 public:
  static constexpr int none = -1;

  void clear() {
    points_.clear();
    words_.fill(0);
  }
  /// All points of a keyframe; `sort` is to follow.
  void add(const auto& keyframe) {
    for (const PlaceFeature& feature : keyframe.features) {
      if (feature.point == PlaceFeature::no_point || !points_.push_back(feature.point)) continue;
      words_[word(feature.point)] |= bit(feature.point);
    }
  }
  void sort() {
    std::sort(points_.begin(), points_.end());
    points_.resize(std::size_t(std::unique(points_.begin(), points_.end()) - points_.begin()));
  }
  std::size_t size() const { return points_.size(); }
  std::uint32_t operator[](std::size_t n) const { return points_[n]; }
  /// Place of a point in the order of numbers, or `none`.
  int find(std::uint32_t point) const {
    if (!(words_[word(point)] & bit(point))) return none;
    const auto found = std::lower_bound(points_.begin(), points_.end(), point);
    return found != points_.end() && *found == point ? int(found - points_.begin()) : none;
  }
  int count_seen(const auto& keyframe) const {
    int seen = 0;
    for (const PlaceFeature& feature : keyframe.features)
      seen += feature.point != PlaceFeature::no_point && find(feature.point) != none;
    return seen;
  }

 private:
  static std::size_t word(std::uint32_t point) { return point / 64 % 64; }
  static std::uint64_t bit(std::uint32_t point) { return std::uint64_t{1} << (point % 64); }

  FixedVector<std::uint32_t, Capacity> points_;
  std::array<std::uint64_t, 64> words_{};  ///< most points of other keyframes are told by one bit
};

}  // namespace plumbline
