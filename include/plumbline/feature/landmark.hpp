#pragma once
/// A landmark of any kind: what is believed of it, where the frames of the window saw it, and how it looks. The kind
/// says what its geometry, its appearance and an observation are.

#include <array>
#include <cstdint>

namespace plumbline {

template <class KindT, int Slots>
struct Landmark {
  using Kind = KindT;
  using Observation = typename Kind::Observation;

  std::uint32_t id = 0;
  int anchor = 0;                                 ///< slot of the keyframe whose camera the geometry belongs to
  bool located = false;                           ///< the geometry is known
  bool solved = false;                            ///< and was part of the window's last solution
  int misses = 0;                                 ///< frames in a row that should have seen it and did not
  typename Kind::Geometry geometry;               ///< in the anchor's camera
  typename Kind::Appearance appearance;           ///< by which it is recognized
  std::array<Observation, Slots> observations{};  ///< in the frames of the window, by slot
  Observation current;                            ///< in the latest frame
  Observation previous;                           ///< in the one before

  int observation_count() const {
    int n = 0;
    for (const Observation& seen : observations) n += seen.valid;
    return n;
  }
  const Observation& seen_by_anchor() const { return observations[static_cast<std::size_t>(anchor)]; }
  /// Whether the window estimates it: located, and seen by a frame besides its anchor.
  bool takes_part() const { return located && seen_by_anchor().valid && observation_count() >= 2; }
};

}  // namespace plumbline
