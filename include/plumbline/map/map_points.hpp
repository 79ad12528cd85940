#pragma once
/// Points that keyframes of a map see: their features carry the number of the point, the store its patch.
///                                                                                                docs/math/map.md 5
/// A point is the set of features with its number. Two of them become one when a verified match joins them, unless a
/// keyframe sees both.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/tracking/descriptor_matching.hpp"
#include "plumbline/tracking/reference_patch.hpp"

namespace plumbline {

/// Of a point of the map: what alignment needs, and some of what a turn of the view takes away.
using MapPatch = PatchCopy<16, 2>;

template <class Places, int MaxPoints>
class MapPoints {
  static_assert(MaxPoints >= 1 && MaxPoints < 1 << 24, "plumbline: points are numbered by 24 bits");

 public:
  using Keyframe = typename Places::Keyframe;
  static constexpr std::size_t max_features = Places::max_features;
  static constexpr std::uint32_t no_point = PlaceFeature::no_point;

  struct Point {
    int observations = 0;
    int slot = Places::none;    ///< of the keyframe that the patch is from
    std::uint16_t feature = 0;  ///< of that keyframe
    std::uint32_t asked = 0;    ///< by the keyframe with that id
    MapPatch patch;
  };

  MapPoints() { clear(); }
  void clear() {
    free_.clear();
    for (int n = MaxPoints - 1; n >= 0; --n) free_.push_back(std::uint32_t(n));
  }
  std::size_t size() const { return std::size_t(MaxPoints) - free_.size(); }
  const Point& operator[](std::uint32_t point) const { return points_[point]; }

  /// True the first time that a keyframe asks for the point.
  bool ask(std::uint32_t point, std::uint32_t keyframe) {
    return std::exchange(points_[point].asked, keyframe) != keyframe;
  }
  /// A new point, seen by that feature of keyframe k. Without room the feature keeps none.
  void add(Places& places, int k, std::size_t feature, const auto& patch) {
    const std::uint32_t added = acquire();
    if (added == no_point) return;
    Point& point = points_[added];
    point.slot = places.slot(k);
    point.feature = std::uint16_t(feature);
    point.patch.crop(patch);
    assign(places.keyframe(k).features[feature], added);
  }
  /// The landmarks that keyframe k tracks are those of the keyframes before.
  void take_tracks(Places& places, int k) {
    Keyframe& current = places.keyframe(k);
    for (PlaceFeature& feature : current.features) {
      if (feature.landmark == PlaceFeature::no_landmark) continue;
      for (int before = k - 1; before >= 0 && before >= k - track_gap; --before) {
        const Keyframe& earlier = places.keyframe(before);
        if (earlier.world != current.world) break;
        const auto same = std::find_if(earlier.features.begin(), earlier.features.end(),
                                       [&](const PlaceFeature& other) { return other.landmark == feature.landmark; });
        if (same == earlier.features.end()) continue;
        if (same->point != no_point && !sees(current, same->point)) assign(feature, same->point);
        break;
      }
    }
  }
  /// The feature of keyframe k sees that point.
  void observe(Places& places, int k, std::size_t feature, std::uint32_t point) {
    PlaceFeature& seen = places.keyframe(k).features[feature];
    seen.is_recalled = true;
    if (seen.point == point || sees(places.keyframe(k), point)) return;
    if (seen.point == no_point) return assign(seen, point);
    merges_.clear();
    merges_.push_back({seen.point, point});
    merge(places);
  }
  /// Features of the keyframes i and j that see the same point: matches (feature of i, feature of j).
  void join(Places& places, int i, int j, std::span<const DescriptorMatch> matches) {
    merges_.clear();
    Keyframe &a = places.keyframe(i), &b = places.keyframe(j);
    for (const DescriptorMatch& match : matches) {
      PlaceFeature &one = a.features[match.first], &other = b.features[match.second];
      other.is_recalled = true;
      if (one.point == other.point && one.point != no_point) continue;
      if (one.point == no_point && other.point == no_point) {
        const std::uint32_t added = acquire();
        if (added == no_point) continue;
        assign(one, added);
        assign(other, added);
      } else if (one.point == no_point) {
        if (!sees(a, other.point)) assign(one, other.point);
      } else if (other.point == no_point) {
        if (!sees(b, one.point)) assign(other, one.point);
      } else {
        merges_.push_back({std::max(one.point, other.point), std::min(one.point, other.point)});
      }
    }
    merge(places);
  }
  /// A keyframe of the map is about to be removed.
  void forget(Keyframe& keyframe, int slot) {
    for (PlaceFeature& feature : keyframe.features) {
      if (feature.point == no_point) continue;
      Point& point = points_[feature.point];
      if (point.slot == slot) point.slot = Places::none;
      drop(feature);
    }
  }
  /// What a keyframe that retires sees alone, and has not located, is no point.
  void drop_unlocated(Keyframe& keyframe) {
    for (PlaceFeature& feature : keyframe.features) {
      if (feature.point != no_point && !feature.is_located() && points_[feature.point].observations == 1) drop(feature);
    }
  }

 private:
  static constexpr int track_gap = 3;  ///< keyframes; what is not seen for longer is another landmark
  struct Merge {
    std::uint32_t from, to;
    int seen = -1;  ///< the last keyframe that sees `to`
    bool is_refused = false;
  };

  std::uint32_t acquire() {
    if (free_.empty()) return no_point;
    const std::uint32_t point = free_.back();
    free_.pop_back();
    points_[point].observations = 0;
    points_[point].slot = Places::none;
    points_[point].asked = 0;
    return point;
  }
  void assign(PlaceFeature& feature, std::uint32_t point) {
    feature.point = point;
    ++points_[point].observations;
  }
  void drop(PlaceFeature& feature) {
    if (--points_[feature.point].observations == 0) free_.push_back(feature.point);
    feature.point = no_point;
  }
  static bool sees(const Keyframe& keyframe, std::uint32_t point) {
    return std::any_of(keyframe.features.begin(), keyframe.features.end(),
                       [&](const PlaceFeature& feature) { return feature.point == point; });
  }
  /// Renames points, in two passes over all features.
  void merge(Places& places) {
    if (merges_.empty()) return;
    std::sort(merges_.begin(), merges_.end(), [](const Merge& a, const Merge& b) { return a.from < b.from; });
    for (std::size_t m = 0; m < merges_.size(); ++m) {
      // Matches are one to one. What is named twice all the same, is contradictory.
      if (m > 0 && merges_[m].from == merges_[m - 1].from) merges_[m].is_refused = true;
      if (Merge* const chained = merge_of(merges_[m].to)) chained->is_refused = true;
    }
    by_target_.clear();
    for (std::size_t m = 0; m < merges_.size(); ++m) by_target_.push_back(std::uint16_t(m));
    const auto target = [this](std::uint16_t m) { return merges_[m].to; };
    std::sort(by_target_.begin(), by_target_.end(),
              [&](std::uint16_t a, std::uint16_t b) { return target(a) < target(b); });
    for (int k = 0; k < places.size(); ++k) {
      for (const PlaceFeature& feature : places.keyframe(k).features) {
        if (feature.point == no_point) continue;
        auto found = std::lower_bound(by_target_.begin(), by_target_.end(), feature.point,
                                      [&](std::uint16_t m, std::uint32_t point) { return target(m) < point; });
        for (; found != by_target_.end() && target(*found) == feature.point; ++found) merges_[*found].seen = k;
      }
      for (const PlaceFeature& feature : places.keyframe(k).features) {
        if (Merge* const found = merge_of(feature.point); found && found->seen == k) found->is_refused = true;
      }
    }
    for (int k = 0; k < places.size(); ++k) {
      for (PlaceFeature& feature : places.keyframe(k).features) {
        const Merge* const found = merge_of(feature.point);
        if (!found || found->is_refused) continue;
        drop(feature);
        assign(feature, found->to);
      }
    }
  }
  Merge* merge_of(std::uint32_t from) {
    const auto found = std::lower_bound(merges_.begin(), merges_.end(), from,
                                        [](const Merge& merge, std::uint32_t point) { return merge.from < point; });
    return found != merges_.end() && found->from == from ? &*found : nullptr;
  }

  std::array<Point, std::size_t(MaxPoints)> points_;
  FixedVector<std::uint32_t, std::size_t(MaxPoints)> free_;
  FixedVector<Merge, max_features> merges_;
  FixedVector<std::uint16_t, max_features> by_target_;
};

/// Of maps without points of their own.
struct NoMapPoints {
  void join(auto&&...) {}
  void forget(auto&&...) {}
  void drop_unlocated(auto&&...) {}
};

}  // namespace plumbline
