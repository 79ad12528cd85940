#pragma once
/// Derivatives of the rows of one landmark by the readout time of a rolling shutter. docs/math/rolling_shutter.md (3)
///
/// ReadoutDerivatives is passed to a kind in place of its rows (LandmarkElimination): the kind then adds d r/d readout,
/// whitened, weighted and in the order of the rows. Rows of a kind that does not do so have zero derivatives.

#include <array>

#include "plumbline/core/matrix.hpp"

namespace plumbline {

template <class S, int MaxRows>
class ReadoutDerivatives {
 public:
  static constexpr bool takes_derivatives = true;

  int rows() const { return rows_; }
  S operator[](int row) const { return row < rows_ ? derivatives_[row] : S(0); }

  template <int R>
  void add_derivatives(const Vec<S, R>& derivatives) {
    for (int k = 0; k < R && rows_ < MaxRows; ++k) derivatives_[rows_++] = derivatives[k];
  }
  /// Rows that do not depend on the readout time.
  template <int R>
  void add(int /*block*/, const auto& /*J*/, const auto& /*J_l*/, const auto& /*r*/) {
    add_derivatives(zeros<S, R>());
  }
  template <int R>
  void add(const auto& /*J_l*/, const auto& /*r*/) {
    add_derivatives(zeros<S, R>());
  }

 private:
  int rows_ = 0;
  std::array<S, MaxRows> derivatives_;
};

/// Zero derivatives of a global shutter.
struct NoReadoutDerivatives {
  int operator[](int) const { return 0; }
};

/// A type of rows that takes derivatives by the readout time instead of rows.
template <class Rows>
concept TakesDerivatives = requires {
  requires Rows::takes_derivatives;
};

/// Information and gradient of the readout time as an additional unknown of all rows.
struct ReadoutBorder {
  double information = 0, gradient = 0;
};

/// Correction of the readout time, with its sigma [s].
struct ReadoutCorrection {
  double value_s = 0, sigma_s = 0;
};

}  // namespace plumbline
