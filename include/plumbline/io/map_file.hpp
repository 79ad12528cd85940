#pragma once
/// Saved maps as files.

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <span>
#include <vector>

#include "plumbline/io/error.hpp"
#include "plumbline/map/map_archive.hpp"

namespace plumbline::io {

/// The bytes of a file. Throws ReadError.
inline std::vector<std::byte> read_map_bytes(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  if (!in || std::filesystem::is_directory(file)) throw ReadError(file, 0, "cannot be read");
  in.seekg(0, std::ios::end);
  const std::streamoff size = in.tellg();
  in.seekg(0);
  std::vector<std::byte> bytes(size > 0 ? static_cast<std::size_t>(size) : 0);
  in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!in) throw ReadError(file, 0, "cannot be read");
  return bytes;
}

/// What is in a saved map.
struct MapContents {
  struct Keyframe {
    ArchivedKeyframe keyframe;
    std::vector<PlaceFeature> features;

    /// The features whose range is known, in the map.
    template <class Visit>
    void for_each_point(Visit&& visit) const {
      const SE3<double>& T_body_cam = keyframe.T_body_cam;
      const double scale = keyframe.S_map_body.scale();
      for (const PlaceFeature& feature : features) {
        if (!feature.is_located()) continue;
        const Vec<double, 3> p = T_body_cam * Vec<double, 3>(cast_to<double>(feature.bearing) * double(feature.range));
        visit(feature, Vec<double, 3>(keyframe.S_map_body * p), scale);
      }
    }
  };
  MapArchiveHeader header;
  std::vector<Keyframe> keyframes;
  std::vector<ArchivedLoop> loops;
};

/// Throws ReadError, of the file that they are of, where they are no map or are damaged.
inline MapContents map_of_bytes(std::span<const std::byte> bytes, const std::filesystem::path& file) {
  struct Taker {
    MapContents out;
    void keyframe(int, const ArchivedKeyframe& keyframe) { out.keyframes.push_back({keyframe, {}}); }
    void feature(int k, const PlaceFeature& feature) {
      out.keyframes[static_cast<std::size_t>(k)].features.push_back(feature);
    }
    void loop(const ArchivedLoop& loop) { out.loops.push_back(loop); }
  } taker;
  const MapArchiveError error = read_map_archive(bytes, taker);
  if (error != MapArchiveError::none) throw ReadError(file, 0, name_of(error));
  (void)map_archive::read_header(bytes, taker.out.header);
  return taker.out;
}

/// Throws ReadError where the file is no map or is damaged.
inline MapContents read_map(const std::filesystem::path& file) { return map_of_bytes(read_map_bytes(file), file); }

}  // namespace plumbline::io
