#pragma once
/// Which frames of a simulated recording are missing: gaps of 1 to `longest` frames at irregular times.
///
/// Between two gaps 1 + floor(x) frames are there, x exponential with the mean that makes `share` of all be missing.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "plumbline/core/random.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::testing {

/// True: there. The first frame always is.
inline std::vector<bool> frames_kept(int frames, double share, int longest, std::uint64_t seed) {
  std::vector<bool> kept(static_cast<std::size_t>(frames), true);
  if (!(share > 0)) return kept;
  Random random(stream_seed(seed, 5));
  const double mean_run = 0.5 * (1 + longest) * (1 - share) / share;
  for (int i = 0; i < frames;) {
    i += 1 + static_cast<int>(std::max(0.0, mean_run - 0.5) * -std::log(1 - random.uniform()));
    const int gap = 1 + static_cast<int>(longest * random.uniform());
    for (const int end = i + gap; i < end; ++i) {
      if (i < frames) kept[static_cast<std::size_t>(i)] = false;
    }
  }
  return kept;
}

}  // namespace plumbline::testing
