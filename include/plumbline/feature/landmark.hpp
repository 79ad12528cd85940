#pragma once
/// Landmark of any kind: its geometry, its observations by the frames of the window, and its appearance. The kind
/// defines the types of the three.

#include <array>
#include <cstdint>

namespace plumbline {

template <class KindT, int Slots>
struct Landmark {
  using Kind = KindT;
  using Observation = typename Kind::Observation;

  std::uint32_t id = 0;
  int anchor = 0;                                 ///< slot of the keyframe in whose camera the geometry is expressed
  bool located = false;                           ///< the geometry is estimated
  bool solved = false;                            ///< it was part of the last solution of the window
  int misses = 0;                                 ///< frames in a row in which it was searched and not found
  typename Kind::Geometry geometry;               ///< in the anchor's camera
  typename Kind::Appearance appearance;           ///< image data by which it is recognized
  std::array<Observation, Slots> observations{};  ///< by the frames of the window, by slot
  Observation current;                            ///< by the latest frame
  Observation previous;                           ///< by the frame before

  int observation_count() const {
    int n = 0;
    for (const Observation& seen : observations) n += seen.valid;
    return n;
  }
  const Observation& seen_by_anchor() const { return observations[static_cast<std::size_t>(anchor)]; }
  /// Whether the window estimates it: located, and observed by its anchor and by another frame.
  bool takes_part() const { return located && seen_by_anchor().valid && observation_count() >= 2; }
};

}  // namespace plumbline
