#pragma once
/// Descriptors of a keyframe: at the points that are tracked, and at further corners of several pyramid levels.
///                                                                                docs/math/place_recognition.md
///   describe_points(pyramid, tracked, features);        // first: so many of `features` as could be described
///   add_corner_features(pyramid, options, features);    // fills what is left
///
/// A corner of level l is described on level l, where a pixel covers 2^l pixels of the image: coarse levels recognize a
/// place from another distance. They have few corners and are filled first, level 0 last.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"
#include "plumbline/tracking/corner_maxima.hpp"
#include "plumbline/tracking/orb_descriptor.hpp"

namespace plumbline {

struct OrbFeature {
  static constexpr std::uint32_t no_point = 0xFFFFFFFF;

  Vec<float, 2> uv{0, 0};          ///< [px] of level 0
  float angle_rad = 0;             ///< orientation of the patch
  int level = 0;                   ///< of the pyramid it was described on
  std::uint32_t point = no_point;  ///< index of the given point, `no_point` for a further corner
  BinaryDescriptor descriptor;
};

struct OrbFeatureOptions {
  CornerMaximaOptions corners;  ///< on each level; lengths in pixels of the level
  int levels = 3;               ///< from 0 on
};

/// Appends one feature for each point `uv` [px of level 0] that is at least `OrbDescriber::border_px` from the image's
/// edge, in their order, until `out` is full. Returns how many.
template <int Levels, std::size_t MaxPixels, std::size_t N>
std::size_t describe_points(const Pyramid<Levels, MaxPixels>& pyramid, std::span<const Vec<float, 2>> uv,
                            FixedVector<OrbFeature, N>& out) {
  const std::size_t before = out.size();
  for (std::size_t i = 0; i < uv.size() && !out.full(); ++i) {
    const OrbDescription d = OrbDescriber::describe(pyramid.level(0), uv[i]);
    if (d.valid) out.push_back({uv[i], d.angle_rad, 0, static_cast<std::uint32_t>(i), d.descriptor});
  }
  return out.size() - before;
}

/// Appends features at corners until `out` is full or no corner is left. Of the room, level l gets twice as much as
/// level l + 1; what a coarse level does not use is for the finer ones. On level 0 corners keep away from the features
/// that are there. No corner is at a pixel that the mask of the pyramid excludes.
template <int Levels, std::size_t MaxPixels, std::size_t N>
void add_corner_features(const Pyramid<Levels, MaxPixels>& pyramid, const OrbFeatureOptions& options,
                         FixedVector<OrbFeature, N>& out) {
  PLUMBLINE_ASSERT(options.levels >= 1 && options.levels <= Levels);
  CornerMaximaOptions corner_options = options.corners;
  corner_options.border_px = std::max(corner_options.border_px, OrbDescriber::border_px);
  FixedVector<Corner, N> corners;
  FixedVector<Vec<float, 2>, N> existing;
  for (int level = options.levels - 1; level >= 0; --level) {
    if (level == 0) {
      for (const OrbFeature& feature : out) {
        if (feature.level == 0) existing.push_back(feature.uv);
      }
    }
    const std::size_t parts = (std::size_t{2} << level) - 1;  // 1 for this level, 2 + 4 + ... for the finer ones
    const std::size_t room = (N - out.size()) / parts;
    const auto is_excluded = [&](const Vec<float, 2>& uv) { return pyramid.mask().excludes(from_level(uv, level)); };
    detect_corner_maxima<N>(pyramid.level(level), {existing.data(), existing.size()}, corner_options, room, corners,
                            is_excluded);
    for (const Corner& corner : corners) {
      const OrbDescription d = OrbDescriber::describe(pyramid.level(level), corner.uv);
      if (!d.valid) continue;
      out.push_back({from_level(corner.uv, level), d.angle_rad, level, OrbFeature::no_point, d.descriptor});
    }
  }
}

}  // namespace plumbline
