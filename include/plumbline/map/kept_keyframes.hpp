#pragma once
/// The keyframes that a map keeps: those of a map that was taken in, before those of this run.   docs/math/map.md 1, 4
///
/// A keyframe is in the pose graph (place_graph.hpp), in the index of places (hamming_place_index.hpp), and observes
/// points of the map (map_points.hpp). Where it is removed, it is removed from all of them. Ids of this run follow that
/// of the last keyframe that was taken in.

#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/hamming_place_index.hpp"
#include "plumbline/map/map_archive.hpp"
#include "plumbline/map/map_correction.hpp"
#include "plumbline/map/place_archive.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

template <class PlacesT, class PointsT>
class KeptKeyframes {
 public:
  using Places = PlacesT;
  using Points = PointsT;
  using S = typename Places::S;
  using Keyframe = typename Places::Keyframe;
  using Index = HammingPlaceIndex<std::size_t(Places::max_keyframes), Places::max_features>;
  static constexpr int none = Places::none;

  explicit KeptKeyframes(const PlaceGraphOptions& options) : places_(options) {}

  const Places& places() const { return places_; }
  Places& places() { return places_; }
  Points& points() { return points_; }
  Index& index() { return index_; }
  const MapCorrection<Places>& correction() const { return correction_; }
  MapCorrection<Places>& correction() { return correction_; }
  /// Valid until the next call of any function.
  std::span<const BinaryDescriptor> descriptors_of(const Keyframe& keyframe) {
    descriptors_.clear();
    for (const PlaceFeature& feature : keyframe.features) descriptors_.push_back(feature.descriptor);
    return {descriptors_.data(), descriptors_.size()};
  }

  template <class Sink>
  void save(Sink&& sink) const {
    save_places(places_, sink, loaded_ > 0 ? places_.keyframe(0).world : largest_world(places_));
  }
  /// Takes at most `room` keyframes in, before the first one. On an error nothing has changed.
  MapArchiveError load(std::span<const std::byte> bytes, int room) {
    const MapArchiveError error = load_places(bytes, places_, room);
    if (error != MapArchiveError::none) return error;
    loaded_ = places_.size();
    for (int k = 0; k < loaded_; ++k) index_.add(std::uint32_t(places_.slot(k)), descriptors_of(places_.keyframe(k)));
    if (loaded_ > 0) first_id_ = places_.keyframe(loaded_ - 1).id;
    return error;
  }
  /// Keyframes that were taken in.
  int loaded() const { return loaded_; }
  bool is_loaded(const Keyframe& keyframe) const { return keyframe.id <= first_id_; }
  /// Id of a frame of this run.
  std::uint32_t id_of(std::uint32_t sequence) const { return first_id_ + sequence; }

  /// A new keyframe, to be given its features; nullptr where there is no room for it. `finish` ends it.
  Keyframe* begin(std::uint32_t sequence, TimeNs t_ns, const SE3<S>& T_world_body, const SE3<S>& T_body_cam,
                  const Mat<S, 6, 6>& covariance) {
    if (!places_.add(id_of(sequence), t_ns, T_world_body, T_body_cam, covariance)) return nullptr;
    return &places_.keyframe(places_.size() - 1);
  }
  const Keyframe& finish() {
    const int k = places_.size() - 1;
    index_.remove(std::uint32_t(places_.slot(k)));
    index_.add(std::uint32_t(places_.slot(k)), descriptors_of(places_.keyframe(k)));
    return places_.keyframe(k);
  }
  /// Returns the keyframe of a frame that retires; nullptr where it is none.
  Keyframe* retire(std::uint32_t sequence, const SE3<S>& T_world_body) {
    places_.retire(id_of(sequence), T_world_body);
    const int k = places_.find(id_of(sequence));
    return k == none ? nullptr : &places_.keyframe(k);
  }

  /// Removes keyframe k. False, and nothing changed, where the pose graph cannot.
  bool remove(int k) {
    const int slot = places_.slot(k);
    correction_.before_removal(places_, k);
    if (!places_.remove(k)) return false;
    index_.remove(std::uint32_t(slot));
    points_.forget(places_.keyframe_in(slot), slot);
    return true;
  }
  /// Removes the oldest retired keyframe of this run.
  void remove_oldest() {
    int k = loaded_;
    while (k < places_.size() && !places_.keyframe(k).is_retired) ++k;
    if (k == places_.size()) return;
    remove(k);
  }
  void remove_present_world() {
    correction_.forget();
    for (int k = places_.size() - 1; k >= 0 && places_.keyframe(k).world == places_.world(); --k) {
      index_.remove(std::uint32_t(places_.slot(k)));
      points_.forget(places_.keyframe(k), places_.slot(k));
    }
    places_.remove_present_world();
  }

 private:
  Places places_;
  MapCorrection<Places> correction_;
  Points points_;
  Index index_;
  FixedVector<BinaryDescriptor, Places::max_features> descriptors_;
  int loaded_ = 0;              ///< keyframes of the map that was taken in
  std::uint32_t first_id_ = 0;  ///< before those of this run
};

}  // namespace plumbline
