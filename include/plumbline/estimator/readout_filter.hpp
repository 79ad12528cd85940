#pragma once
/// The readout time of a rolling shutter, from what every frame says about it.     docs/math/rolling_shutter.md
///
/// A frame's normal equations of pose and readout give a correction d with variance C. Two things keep a frame from
/// saying all: the angular rate is known to some percent only (a floor), and landmarks measured with a wrong readout
/// hide part of the error, which comes to light as they are replaced (a random walk):
///   P <- P + walk^2 dt,   K = P / (P + C + floor^2),   readout += K d,   P <- (1 - K) P                      (2)

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

struct ReadoutOptions {
  double floor_s = 3e-3;  ///< a single frame is never better than this
  double walk = 2e-3;     ///< [s/sqrt(s)]
  double max_s = 0.05;
};

template <class S>
class ReadoutFilter {
 public:
  ReadoutFilter(const Readout<S>& prior, const ReadoutOptions& options) : options_(options), readout_(prior) {}

  const Readout<S>& readout() const { return readout_; }
  bool known() const { return !(readout_.sigma_s > S(0)); }

  /// Takes in the normal equations of one frame, pose first, readout last, `dt` [s] after the one before.
  void update(const DenseNormalEquations<S, 7>& system, S dt) {
    Vec<S, 7> d;
    Mat<S, 7, 7> covariance;
    if (!system.solve(d) || !system.covariance(covariance)) return;
    const S floor = S(options_.floor_s), walk = S(options_.walk);
    const S P = readout_.sigma_s * readout_.sigma_s + walk * walk * dt;
    const S K = P / (P + covariance(6, 6) + floor * floor);  // (2)
    if (!(K >= S(0))) return;
    readout_.value_s = std::clamp(readout_.value_s + K * d(6), S(0), S(options_.max_s));
    readout_.sigma_s = std::sqrt((S(1) - K) * P);
  }

 private:
  ReadoutOptions options_;
  Readout<S> readout_;
};

}  // namespace plumbline
