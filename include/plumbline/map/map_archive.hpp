#pragma once
/// The bytes of a saved map, version 1. Numbers are little-endian; rotations are quaternions x y z w.
/// docs/math/map.md 4
///
///   "plumbmap", version u32, degrees of freedom u32 (4: metric, z up; 6: metric; 7: its own unit), keyframes u32,
///   features u32 (of all keyframes), loops u32
///   keyframe:  id u32, world u32, t i64 [ns], S_map_body 8 f64 (scale, q, t), T_world_body 7 f64 (q, p), T_body_cam,
///              T_before_body, covariance of T_before_body 21 f64 (upper triangle), features u32, and of each feature
///              descriptor 4 u64, bearing 3 f32, its sigma [rad], range f32 (0: not known), its sigma
///   loop:      i u32, j u32 (places of its keyframes), S_i_j, covariance (upper triangle, f64)
///   CRC-32 of all before it
/// A reader checks size, checksum, version and every number before it takes anything in.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/archive_bytes.hpp"
#include "plumbline/map/place_keyframe.hpp"

namespace plumbline {

enum class MapArchiveError : std::uint8_t {
  none,
  not_a_map,      ///< other bytes
  other_version,  ///< of another version of this format
  cut_off,        ///< fewer or more bytes than the header says
  damaged,        ///< a wrong checksum, a number that is not finite, an index out of range
  other_sensors,  ///< the rig of the map knows gravity or the unit, this one does not, or the other way round
  no_room,        ///< more keyframes, loops or features of a keyframe than this map holds
  not_empty,      ///< keyframes are there already: maps are loaded before the first frame
};

constexpr const char* name_of(MapArchiveError error) {
  switch (error) {
    case MapArchiveError::none: return "no error";
    case MapArchiveError::not_a_map: return "not a map";
    case MapArchiveError::other_version: return "a map of another version of the format";
    case MapArchiveError::cut_off: return "its size is not what its header says";
    case MapArchiveError::damaged: return "damaged (wrong checksum or numbers)";
    case MapArchiveError::other_sensors: return "made by another kind of sensors";
    case MapArchiveError::no_room: return "larger than the map that is to hold it";
    case MapArchiveError::not_empty: return "the map has keyframes already";
  }
  return "unknown error";
}

struct MapArchiveHeader {
  std::uint32_t dim = 0, keyframes = 0, features = 0, loops = 0;
};

struct ArchivedKeyframe {
  std::uint32_t id = 0, world = 0;
  TimeNs t_ns = 0;
  Sim3<double> S_map_body;
  SE3<double> T_world_body, T_body_cam, T_before;
  Mat<double, 6, 6> Q = zeros<double, 6, 6>();
  std::uint32_t features = 0;
};

struct ArchivedLoop {
  std::uint32_t i = 0, j = 0;
  Sim3<double> S_i_j;
  Mat<double, 7, 7> covariance = zeros<double, 7, 7>();  ///< the first `dim` rows and columns
};

namespace map_archive {

inline constexpr std::string_view magic = "plumbmap";
inline constexpr std::uint32_t version = 1;
inline constexpr std::uint64_t header_bytes = 28, keyframe_bytes = 20 + 8 * (8 + 3 * 7 + 21), feature_bytes = 56;
inline std::uint64_t loop_bytes(std::uint64_t dim) { return 8 + 8 * (8 + dim * (dim + 1) / 2); }

template <class Sink>
void write(ArchiveWriter<Sink>& out, const MapArchiveHeader& header) {
  out.text(magic);
  for (const std::uint32_t n : {version, header.dim, header.keyframes, header.features, header.loops}) out.number(n);
}
template <class Sink>
void write(ArchiveWriter<Sink>& out, const ArchivedKeyframe& keyframe) {
  out.number(keyframe.id);
  out.number(keyframe.world);
  out.number(std::int64_t(keyframe.t_ns));
  out.similarity(keyframe.S_map_body);
  for (const SE3<double>& T : {keyframe.T_world_body, keyframe.T_body_cam, keyframe.T_before}) out.pose(T);
  out.symmetric(keyframe.Q);
  out.number(keyframe.features);
}
template <class Sink>
void write(ArchiveWriter<Sink>& out, const PlaceFeature& feature) {
  for (const std::uint64_t word : feature.descriptor.words) out.number(word);
  for (int k = 0; k < 3; ++k) out.number(feature.bearing[k]);
  for (const float x : {feature.sigma_rad, feature.range, feature.sigma_range}) out.number(x);
}
template <class Sink>
void write(ArchiveWriter<Sink>& out, const ArchivedLoop& loop, int dim) {
  out.number(loop.i);
  out.number(loop.j);
  out.similarity(loop.S_i_j);
  out.symmetric(loop.covariance, dim);
}

inline ArchivedKeyframe read_keyframe(ArchiveReader& in) {
  ArchivedKeyframe out;
  out.id = in.number<std::uint32_t>();
  out.world = in.number<std::uint32_t>();
  out.t_ns = TimeNs(in.time());
  out.S_map_body = in.similarity();
  for (SE3<double>* const T : {&out.T_world_body, &out.T_body_cam, &out.T_before}) *T = in.pose();
  out.Q = in.symmetric<6>();
  out.features = in.number<std::uint32_t>();
  return out;
}
inline PlaceFeature read_feature(ArchiveReader& in) {
  PlaceFeature out;
  for (std::uint64_t& word : out.descriptor.words) word = in.number<std::uint64_t>();
  for (int k = 0; k < 3; ++k) out.bearing[k] = in.real32();
  for (float* const x : {&out.sigma_rad, &out.range, &out.sigma_range}) *x = in.real32();
  return out;
}
inline ArchivedLoop read_loop(ArchiveReader& in, int dim) {
  ArchivedLoop out;
  out.i = in.number<std::uint32_t>();
  out.j = in.number<std::uint32_t>();
  out.S_i_j = in.similarity();
  out.covariance = in.symmetric<7>(dim);
  return out;
}
/// Keyframes and worlds that follow have larger numbers.
inline bool is_sound(const ArchivedKeyframe& keyframe) {
  constexpr std::uint32_t largest = 1u << 31;
  return keyframe.id < largest && keyframe.world < largest;
}
inline bool is_sound(const PlaceFeature& feature) {
  const float unit = squared_norm(feature.bearing);
  return unit > 0.99f && unit < 1.01f && feature.sigma_rad > 0 && feature.range >= 0 &&
         (feature.range == 0 || feature.sigma_range > 0);
}

/// The header of a saved map whose size and checksum are right.
inline MapArchiveError read_header(std::span<const std::byte> bytes, MapArchiveHeader& header) {
  ArchiveReader in(bytes);
  if (!in.text(magic)) return MapArchiveError::not_a_map;
  if (in.number<std::uint32_t>() != version) return MapArchiveError::other_version;
  for (std::uint32_t* const n : {&header.dim, &header.keyframes, &header.features, &header.loops})
    *n = in.number<std::uint32_t>();
  if (!in.is_good()) return MapArchiveError::cut_off;
  if (header.dim != 4 && header.dim != 6 && header.dim != 7) return MapArchiveError::damaged;
  const std::uint64_t size = header_bytes + keyframe_bytes * header.keyframes + feature_bytes * header.features +
                             loop_bytes(header.dim) * header.loops + 4;
  if (size != bytes.size()) return MapArchiveError::cut_off;
  const std::uint32_t sum = crc32(bytes.first(bytes.size() - 4));
  ArchiveReader last(bytes.last(4));
  return last.number<std::uint32_t>() == sum ? MapArchiveError::none : MapArchiveError::damaged;
}

}  // namespace map_archive

/// Reads a saved map: visitor.keyframe(k, ArchivedKeyframe), .feature(k, PlaceFeature) of each, .loop(ArchivedLoop).
/// Keyframes come in order of id. What was visited before an error is of no use: visit first with a visitor that keeps
/// nothing.
template <class Visitor>
MapArchiveError read_map_archive(std::span<const std::byte> bytes, Visitor&& visitor) {
  using namespace map_archive;
  MapArchiveHeader header;
  if (const MapArchiveError error = read_header(bytes, header); error != MapArchiveError::none) return error;
  ArchiveReader in(bytes.subspan(header_bytes));
  std::uint64_t features = 0;
  std::uint32_t last_id = 0;
  for (std::uint32_t k = 0; k < header.keyframes; ++k) {
    const ArchivedKeyframe keyframe = read_keyframe(in);
    features += keyframe.features;
    if (!in.is_good() || features > header.features || (k > 0 && keyframe.id <= last_id) || !is_sound(keyframe))
      return MapArchiveError::damaged;
    last_id = keyframe.id;
    visitor.keyframe(int(k), keyframe);
    for (std::uint32_t n = 0; n < keyframe.features; ++n) {
      const PlaceFeature feature = read_feature(in);
      if (!in.is_good() || !is_sound(feature)) return MapArchiveError::damaged;
      visitor.feature(int(k), feature);
    }
  }
  for (std::uint32_t l = 0; l < header.loops; ++l) {
    const ArchivedLoop loop = read_loop(in, int(header.dim));
    if (!in.is_good() || loop.i >= header.keyframes || loop.j >= header.keyframes || loop.i == loop.j)
      return MapArchiveError::damaged;
    visitor.loop(loop);
  }
  return features == header.features && in.left() == 4 ? MapArchiveError::none : MapArchiveError::damaged;
}

}  // namespace plumbline
