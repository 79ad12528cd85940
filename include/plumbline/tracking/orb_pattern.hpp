#pragma once
/// Sampling pattern of the binary descriptor: 256 pairs of points around the patch's center.
///                                                                                docs/math/place_recognition.md
///   x, y of both points ~ N(0, (S/5)^2),  S = 31 px,  |(x, y)| <= 15 px,  |p - q| >= 2 px                       (3)
/// The rule of BRIEF G II, with a fixed seed. The normal distribution is the sum of twelve uniform numbers, so that the
/// table is computed by the compiler.

#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/random.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

struct OrbPattern {
  static constexpr int radius = 15;  ///< of the disc that holds all points [px]
  static constexpr std::size_t pairs = BinaryDescriptor::bits;

  /// Points p and q of each pair, relative to the center [px].
  std::array<float, pairs> px{}, py{}, qx{}, qy{};
};

namespace detail {

constexpr int normal_offset(Random& random) {
  constexpr double sigma = 31.0 / 5;
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  const double offset = sigma * sum;
  return static_cast<int>(offset < 0 ? offset - 0.5 : offset + 0.5);
}

constexpr OrbPattern make_orb_pattern(std::uint64_t seed) {
  Random random(seed);
  OrbPattern out;
  for (std::size_t i = 0; i < OrbPattern::pairs;) {
    const int px = normal_offset(random), py = normal_offset(random);
    const int qx = normal_offset(random), qy = normal_offset(random);
    constexpr int r2 = OrbPattern::radius * OrbPattern::radius;
    const int dx = px - qx, dy = py - qy;
    if (px * px + py * py > r2 || qx * qx + qy * qy > r2 || dx * dx + dy * dy < 4) continue;
    out.px[i] = static_cast<float>(px);
    out.py[i] = static_cast<float>(py);
    out.qx[i] = static_cast<float>(qx);
    out.qy[i] = static_cast<float>(qy);
    ++i;
  }
  return out;
}

}  // namespace detail

/// (3)
inline constexpr OrbPattern orb_pattern = detail::make_orb_pattern(1);

}  // namespace plumbline
