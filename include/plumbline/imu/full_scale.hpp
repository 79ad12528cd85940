#pragma once
/// Detection of the full scale of a sensor from its samples, for a missing or wrong calibration.       docs/math/imu.md
///
/// At saturation an axis takes the same largest value again and again, and hardly ever the next smaller one. Only
/// arrivals at that value are counted: a coarse sensor of a stationary body repeats its value, too.

#include <array>
#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

struct FullScaleOptions {
  double min_full_scale = 0;  ///< smallest possible full scale, in units of the sensor; numerics: no limit
  /// Arrivals at the largest value before it counts as full scale; tuned: docs/decisions/005.
  int min_arrivals = 10;
  /// Smallest ratio of its arrivals to those at the next smaller value; tuned: docs/decisions/005.
  double min_ratio = 4;
  int max_samples = 1000;  ///< samples after which the counts are reset; tuned: docs/decisions/005
};

class FullScaleFinder {
 public:
  explicit FullScaleFinder(const FullScaleOptions& options) : options_(options) {}

  void add(const Vec<double, 3>& sample) {
    const bool is_exceeded = max_abs(sample) > found_;
    if (is_exceeded) found_ = not_found;
    if (is_exceeded || ++count_ > options_.max_samples) {
      extremes_ = {};
      count_ = 1;
    }
    for (int k = 0; k < 3; ++k) {
      add(extremes_[2 * k], sample[k]);
      add(extremes_[2 * k + 1], -sample[k]);
    }
  }

  /// The smallest detected full scale of any axis; infinity without one. It is discarded when any axis exceeds it.
  double found() const { return found_; }

 private:
  static constexpr double not_found = std::numeric_limits<double>::infinity();

  /// The two largest values of an axis in one direction, and the number of arrivals at each.
  struct Extreme {
    double highest = -not_found, below = -not_found, latest = -not_found;
    int arrivals = 0, arrivals_below = 0;
  };

  void add(Extreme& extreme, double value) {
    const bool arrives = value != extreme.latest;
    extreme.latest = value;
    if (value > extreme.highest) {
      extreme.below = extreme.highest;
      extreme.arrivals_below = extreme.arrivals;
      extreme.highest = value;
      extreme.arrivals = 1;
    } else if (value == extreme.highest) {
      extreme.arrivals += arrives;
    } else if (value > extreme.below) {
      extreme.below = value;
      extreme.arrivals_below = 1;
    } else if (value == extreme.below) {
      extreme.arrivals_below += arrives;
    }
    const bool is_saturated =
        extreme.arrivals >= options_.min_arrivals && extreme.arrivals > options_.min_ratio * extreme.arrivals_below;
    if (is_saturated && extreme.highest >= options_.min_full_scale) found_ = std::fmin(found_, extreme.highest);
  }

  FullScaleOptions options_;
  std::array<Extreme, 6> extremes_;  ///< of each axis, in both directions
  double found_ = not_found;
  int count_ = 0;
};

}  // namespace plumbline
