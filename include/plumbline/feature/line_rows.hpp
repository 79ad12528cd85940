#pragma once
/// Whitened, robust-weighted rows of what one frame measured of a line, by the line in its camera.   docs/math/line.md
///
/// Two rows of the segment, and two of the depth at its ends where it was measured. Their derivatives by the readout
/// time, the line in the anchor fixed (docs/math/rolling_shutter.md):
///   dr_i/d readout = k_i nh^T db_i/d readout                                                                   (3)
/// Depth rows neglect it, because their noise is larger.

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/residual/line_observation.hpp"

namespace plumbline {

/// Observation: segment_observation.hpp. Loss: solver/robust_loss.hpp, of both measurements.
template <class Observation, class Loss>
struct LineRows {
  using S = typename decltype(Observation::pixels)::S;
  static constexpr int max_rows = Observation::measures_depth ? 4 : 2;
  /// Of an observation that is not valid at the current state; numerics: above the cost of any inlier.
  static constexpr double invalid_cost = 100;

  int rows = 0;  ///< valid rows of `lin`; 0 where the line is not visible. The other rows are zero
  double cost = invalid_cost;
  Mat<S, 2, 2> wL;  ///< weighted L of the pixels
  CameraLineLinearization<S, max_rows> lin{true, zeros<S, max_rows>(), zeros<S, max_rows, 3>(),
                                           zeros<S, max_rows, 3>()};

  template <class Measurement>
  LineRows(const SegmentMeasurement<Measurement>& seen, const Plucker<S>& line, const Loss& loss) {
    add<0>(seen, line, loss);
  }
  LineRows(const Observation& seen, const Plucker<S>& line, const Loss& loss) : LineRows(seen.pixels, line, loss) {
    if constexpr (Observation::measures_depth) {
      if (rows > 0 && seen.has_depth()) add<2>(seen.depth.get(), line, loss);
    }
  }

  /// Adds the derivatives (3) of the valid rows; zeros for depth rows.
  void add_derivatives(auto& derivatives, const Observation& seen, const Plucker<S>& line) const {
    const Vec<S, 3> nh = normalized(line.n);
    const Mat<S, 3, 2> by_readout = seen.by_readout();
    Vec<S, 2> r;
    for (int i = 0; i < 2; ++i) r[i] = seen.pixels.measured.px_per_rad[i] * dot(nh, column(by_readout, i));
    if (rows > 0) derivatives.add_derivatives(Vec<S, 2>(wL * r));
    if (rows > 2) derivatives.add_derivatives(zeros<S, max_rows - 2>());
  }

 private:
  template <int first, class Measurement>
  void add(const SegmentMeasurement<Measurement>& seen, const Plucker<S>& line, const Loss& loss) {
    const CameraLineLinearization<S, 2> one = seen.measured.linearize(line);
    if (!one.valid) return;
    const Vec<S, 2> r = seen.L * one.r;
    const S squared = squared_norm(r), w = std::sqrt(loss.weight(squared));
    const Mat<S, 2, 2> weighted = w * seen.L;
    if (first == 0) wL = weighted;
    set_segment(lin.r, first, Vec<S, 2>(w * r));
    set_block(lin.J_r_n, first, 0, product(weighted, one.J_r_n));
    set_block(lin.J_r_v, first, 0, product(weighted, one.J_r_v));
    cost = (first > 0 ? cost : 0) + double(loss.rho(squared)) / 2;
    rows = first + 2;
  }
};

}  // namespace plumbline
