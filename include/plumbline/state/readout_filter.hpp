#pragma once
/// The readout time of a rolling shutter, from what every frame says about it.     docs/math/rolling_shutter.md
///
/// A frame's normal equations of pose and readout give a correction d with variance C. Two things keep a frame from
/// saying all: the angular rate is known to some percent only (a floor), and landmarks measured with a wrong readout
/// hide part of the error, which comes to light as they are replaced (a random walk):
///   P <- P + walk^2 dt,   K = P / (P + C + floor^2),   found += K (readout + d - found),   P <- (1 - K) P     (2)
/// What is found is the readout; a value that is held (a camera taken for one with a global shutter) stays until what is
/// found is beyond doubt another.

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

struct ReadoutOptions {
  double floor_s = 3e-3;  ///< a single frame is never better than this
  double walk = 2e-3;     ///< [s/sqrt(s)]
  double max_s = 0.05;
  double doubt_s = 6e-3;    ///< a value that is held gives way to one that differs by more,
  double doubt_sigmas = 5;  ///< and by so many sigma
};

/// What a single frame of a rolling shutter tells of.
using PoseAndReadout = Layout<state::Pose, state::ReadoutTime>;

template <class S>
class ReadoutFilter {
 public:
  using Equations = DenseNormalEquations<S, PoseAndReadout::dim>;

  ReadoutFilter() = default;
  ReadoutFilter(const Readout<S>& prior, const ReadoutOptions& options)
      : options_(options), readout_(prior), found_s_(prior.value_s) {}

  const Readout<S>& readout() const { return readout_; }
  bool known() const { return !(readout_.sigma_s > S(0)); }

  /// Takes in the normal equations of one frame, `dt` [s] after the one before.
  void update(const Equations& system, S dt) {
    constexpr int dim = PoseAndReadout::dim, at = PoseAndReadout::offset<state::ReadoutTime>;
    Vec<S, dim> d;
    Mat<S, dim, dim> covariance;
    if (!system.solve(d) || !system.covariance(covariance)) return;
    const S floor = S(options_.floor_s), walk = S(options_.walk);
    const S P = readout_.sigma_s * readout_.sigma_s + walk * walk * dt;
    const S K = P / (P + covariance(at, at) + floor * floor);  // (2)
    if (!(K >= S(0))) return;
    found_s_ = std::clamp(found_s_ + K * (readout_.value_s + d[at] - found_s_), S(0), S(options_.max_s));
    readout_.sigma_s = std::sqrt((S(1) - K) * P);
    const S doubt = std::max(S(options_.doubt_s), S(options_.doubt_sigmas) * readout_.sigma_s);
    readout_.is_held = readout_.is_held && !(std::abs(found_s_ - readout_.value_s) > doubt);
    if (!readout_.is_held) readout_.value_s = found_s_;
  }

 private:
  ReadoutOptions options_;
  Readout<S> readout_;
  S found_s_ = S(0);
};

}  // namespace plumbline
