#pragma once
/// The full scale of a sensor that the calibration says nothing of, or something wrong.                docs/math/imu.md
///
/// Readings pile up at a rail: an axis comes to the same largest number again and again, and hardly ever to the next
/// smaller one that it shows. One that stays there says nothing: a coarse sensor at rest repeats itself as well.

#include <array>
#include <cmath>
#include <limits>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

struct FullScaleOptions {
  double least = 0;       ///< full scale of the sensor, at any rate
  int min_arrivals = 10;  ///< at the largest number
  double clear = 4;       ///< times as many as at the next smaller one
  int readings = 1000;    ///< after so many the counts begin anew
};

class FullScaleFinder {
 public:
  explicit FullScaleFinder(const FullScaleOptions& options) : options_(options) {}

  void add(const Vec<double, 3>& reading) {
    const bool was_none = max_abs(reading) > found_;
    if (was_none) found_ = none;
    if (was_none || ++count_ > options_.readings) {
      tops_ = {};
      count_ = 1;
    }
    for (int k = 0; k < 3; ++k) {
      add(tops_[2 * k], reading[k]);
      add(tops_[2 * k + 1], -reading[k]);
    }
  }

  /// Largest number of an axis that was at its rail; infinity when none was. What is exceeded, on any axis, was none.
  double found() const { return found_; }

 private:
  static constexpr double none = std::numeric_limits<double>::infinity();

  /// The two highest values of an axis in one direction, and how often it came to each.
  struct Top {
    double highest = -none, below = -none, latest = -none;
    int arrivals = 0, arrivals_below = 0;
  };

  void add(Top& top, double value) {
    const bool arrives = value != top.latest;
    top.latest = value;
    if (value > top.highest) {
      top.below = top.highest;
      top.arrivals_below = top.arrivals;
      top.highest = value;
      top.arrivals = 1;
    } else if (value == top.highest) {
      top.arrivals += arrives;
    } else if (value > top.below) {
      top.below = value;
      top.arrivals_below = 1;
    } else if (value == top.below) {
      top.arrivals_below += arrives;
    }
    const bool piles_up = top.arrivals >= options_.min_arrivals && top.arrivals > options_.clear * top.arrivals_below;
    if (piles_up && top.highest >= options_.least) found_ = std::fmin(found_, top.highest);
  }

  FullScaleOptions options_;
  std::array<Top, 6> tops_;
  double found_ = none;
  int count_ = 0;
};

}  // namespace plumbline
