#pragma once
/// How the rows of one landmark depend on the readout time of a rolling shutter.    docs/math/rolling_shutter.md (3)
///
/// It takes the place of the rows themselves (LandmarkElimination): a kind that is asked for rows gives, whitened and
/// weighted as these and in their order, d r/d readout. The rows of kinds that do not have none.

#include <array>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <class S, int MaxRows>
class ReadoutSlopes {
 public:
  static constexpr bool takes_slopes = true;

  int rows() const { return rows_; }
  S operator[](int row) const { return row < rows_ ? slopes_[row] : S(0); }

  template <int R>
  void add_slopes(const Vec<S, R>& slopes) {
    for (int k = 0; k < R && rows_ < MaxRows; ++k) slopes_[rows_++] = slopes[k];
  }
  /// Rows that do not depend on it.
  template <int R>
  void add(int /*block*/, const auto& /*J*/, const auto& /*J_l*/, const auto& /*r*/) {
    add_slopes(zeros<S, R>());
  }
  template <int R>
  void add(const auto& /*J_l*/, const auto& /*r*/) {
    add_slopes(zeros<S, R>());
  }

 private:
  int rows_ = 0;
  std::array<S, MaxRows> slopes_;
};

/// Of a shutter that reads all rows at once.
struct NoSlopes {
  int operator[](int) const { return 0; }
};

/// Rows of which the slopes are asked for alone.
template <class Rows>
concept TakesSlopes = requires {
  requires Rows::takes_slopes;
};

/// The readout time as one more unknown that all rows see: its information and its gradient.
struct ReadoutBorder {
  double information = 0, gradient = 0;
};

/// By how much the readout time is wrong, and how well that is known [s].
struct ReadoutCorrection {
  double value_s = 0, sigma_s = 0;
};

}  // namespace plumbline
