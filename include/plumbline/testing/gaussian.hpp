#pragma once
/// Deterministic normal deviates (Box-Muller over core/random.hpp): the same sequence in every standard library.

#include <cmath>
#include <cstdint>
#include <numbers>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/random.hpp"

namespace plumbline::testing {

/// An independent seed for each stream of one recording (camera noise, depth noise, IMU, ...).
constexpr std::uint64_t stream_seed(std::uint64_t seed, std::uint64_t stream, std::uint64_t index = 0) {
  return Random(Random(Random(seed).next() + stream).next() + index).next();
}

class Gaussian {
 public:
  explicit Gaussian(std::uint64_t seed = 1) : random_(seed) {}

  /// One deviate of N(0, 1).
  double operator()() {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    const double radius = std::sqrt(-2 * std::log(1 - random_.uniform()));  // 1 - u is in (0, 1]
    const double angle = 2 * std::numbers::pi * random_.uniform();
    spare_ = radius * std::sin(angle);
    has_spare_ = true;
    return radius * std::cos(angle);
  }

  template <int N>
  Vec<double, N> vector() {
    Vec<double, N> out;
    for (int i = 0; i < N; ++i) out[i] = (*this)();
    return out;
  }

  Random& random() { return random_; }

 private:
  Random random_;
  double spare_ = 0;
  bool has_spare_ = false;
};

}  // namespace plumbline::testing
