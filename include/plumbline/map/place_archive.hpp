#pragma once
/// Saves the keyframes of a map, and restores them in one that is empty.                          docs/math/map.md 4
///
/// Saved are the retired keyframes of one world, and of all worlds that loops connect with it: poses of others are not
/// known in the map. It is the world of the map that was taken in, else the one with the most keyframes. Restored
/// keyframes are a world of the past, which the present world joins where it recognizes a place.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/map_archive.hpp"
#include "plumbline/map/pose_graph.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

/// Which keyframes of a map are saved, by their place in the order.
template <class Places>
class SavedPlaces {
 public:
  SavedPlaces(const Places& places, std::uint32_t world) {
    worlds_.push_back(world);
    for (std::size_t known = 0; known != worlds_.size();) {
      known = worlds_.size();
      for (int l = 0; l < places.graph().loops(); ++l) {
        const auto& loop = places.graph().loop(l);
        const std::uint32_t a = places.keyframe(loop.i).world, b = places.keyframe(loop.j).world;
        if (has(a) != has(b) && !worlds_.full()) worlds_.push_back(has(a) ? b : a);
      }
    }
    for (int k = 0; k < places.size(); ++k) {
      index_[std::size_t(k)] = std::int16_t(count_);
      if (places.keyframe(k).is_retired && has(places.keyframe(k).world)) ++count_;
    }
    end_ = places.size();
  }

  int count() const { return count_; }
  bool is_saved(int k) const { return index_[std::size_t(k)] != (k + 1 < end_ ? index_[std::size_t(k + 1)] : count_); }
  /// Place among the saved ones.
  int index(int k) const { return index_[std::size_t(k)]; }

 private:
  bool has(std::uint32_t world) const {
    for (const std::uint32_t known : worlds_) {
      if (known == world) return true;
    }
    return false;
  }

  FixedVector<std::uint32_t, Places::Graph::max_loops + 1> worlds_;
  std::array<std::int16_t, std::size_t(Places::max_keyframes)> index_{};
  int count_ = 0, end_ = 0;
};

/// The world with the most retired keyframes; 0 without one.
template <class Places>
std::uint32_t largest_world(const Places& places) {
  std::uint32_t largest = 0;
  int most = 0, count = 0;
  for (int k = 0; k < places.size(); ++k) {  // those of a world follow each other
    if (k == 0 || places.keyframe(k).world != places.keyframe(k - 1).world) count = 0;
    count += places.keyframe(k).is_retired;
    if (count <= most) continue;
    most = count;
    largest = places.keyframe(k).world;
  }
  return largest;
}

/// Calls sink(std::span<const std::byte>) with the bytes of the saved map, in order.
template <class Places, class Sink>
void save_places(const Places& places, Sink&& sink, std::uint32_t world) {
  const SavedPlaces<Places> saved(places, world);
  constexpr int dim = Places::Residual::dim;
  MapArchiveHeader header{std::uint32_t(dim), std::uint32_t(saved.count()), 0, 0};
  for (int k = 0; k < places.size(); ++k) {
    if (saved.is_saved(k)) header.features += std::uint32_t(places.keyframe(k).features.size());
  }
  const auto is_saved = [&](int l) {
    return saved.is_saved(places.graph().loop(l).i) && saved.is_saved(places.graph().loop(l).j);
  };
  for (int l = 0; l < places.graph().loops(); ++l) header.loops += is_saved(l);

  ArchiveWriter out(sink);
  map_archive::write(out, header);
  int before = Places::none;
  Mat<double, 6, 6> Q = zeros<double, 6, 6>();  // from the last keyframe saved
  for (int k = 0; k < places.size(); ++k) {
    const auto& keyframe = places.keyframe(k);
    const bool follows = before != Places::none && places.keyframe(before).world == keyframe.world;
    ArchivedKeyframe archived;
    archived.id = keyframe.id;
    archived.world = keyframe.world;
    archived.t_ns = keyframe.t_ns;
    archived.S_map_body = Places::Poses::to_sim3(places.graph().pose(k)).template cast<double>();
    archived.T_world_body = keyframe.T_world_body.template cast<double>();
    archived.T_body_cam = keyframe.T_body_cam.template cast<double>();
    if (follows)
      archived.T_before =
          places.keyframe(before).T_world_body.template cast<double>().inverse() * archived.T_world_body;
    if (k > 0 && places.keyframe(k - 1).world == keyframe.world)
      Q = transported(Q, places.keyframe(k - 1).T_world_body.template cast<double>(), archived.T_world_body);
    Q += cast_to<double>(keyframe.Q);
    if (!saved.is_saved(k)) continue;
    archived.Q = Q;
    set_zero(Q);
    before = k;
    archived.features = std::uint32_t(keyframe.features.size());
    map_archive::write(out, archived);
    for (const PlaceFeature& feature : keyframe.features) map_archive::write(out, feature);
  }
  for (int l = 0; l < places.graph().loops(); ++l) {
    if (!is_saved(l)) continue;
    const auto& loop = places.graph().loop(l);
    ArchivedLoop archived{std::uint32_t(saved.index(loop.i)), std::uint32_t(saved.index(loop.j)),
                          Places::Poses::to_sim3(loop.edge.residual.measured).template cast<double>(),
                          zeros<double, 7, 7>()};
    const auto covariance = loop.edge.covariance();
    for (int a = 0; a < dim; ++a)
      for (int b = 0; b < dim; ++b) archived.covariance(a, b) = double(covariance(a, b));
    map_archive::write(out, archived, dim);
  }
  out.number(std::uint32_t(out.checksum()));
}

/// Restores at most `room` saved keyframes in `places`, which is empty. On an error it stays so.
template <class Places>
MapArchiveError load_places(std::span<const std::byte> bytes, Places& places, int room = Places::max_keyframes) {
  using S = typename Places::S;
  constexpr int dim = Places::Residual::dim;
  struct Check {
    bool fits = true;
    void keyframe(int, const ArchivedKeyframe& keyframe) { fits = fits && keyframe.features <= Places::max_features; }
    void feature(int, const PlaceFeature&) {}
    void loop(const ArchivedLoop&) {}
  } check;
  struct Taker {
    Places& places;
    bool is_good = true;
    void keyframe(int, const ArchivedKeyframe& archived) { is_good = is_good && places.restore(archived); }
    void feature(int k, const PlaceFeature& feature) {
      if (is_good) places.keyframe(k).features.push_back(feature);
    }
    void loop(const ArchivedLoop& loop) {
      typename Places::Covariance covariance = zeros<typename Places::Covariance>();
      for (int a = 0; a < dim; ++a)
        for (int b = 0; b < dim; ++b) covariance(a, b) = S(loop.covariance(a, b));
      const auto S_i_j = loop.S_i_j.template cast<S>();
      is_good = is_good && places.graph().add_loop(int(loop.i), int(loop.j), Places::Poses::from_sim3(S_i_j),
                                                   covariance) == PoseGraphInsertion::inserted;
    }
  } taker{places};

  if (places.size() > 0) return MapArchiveError::not_empty;
  if (const MapArchiveError error = read_map_archive(bytes, check); error != MapArchiveError::none) return error;
  MapArchiveHeader header;
  (void)map_archive::read_header(bytes, header);
  if (int(header.dim) != dim) return MapArchiveError::other_sensors;
  if (header.keyframes > std::uint32_t(room > 0 ? room : 0) || header.loops > std::uint32_t(Places::Graph::max_loops) ||
      !check.fits)
    return MapArchiveError::no_room;
  (void)read_map_archive(bytes, taker);
  if (taker.is_good) return MapArchiveError::none;
  places.clear();
  return MapArchiveError::damaged;
}

}  // namespace plumbline
