#pragma once
/// What the calibration says of where the camera sits on the body.                          docs/math/camera_imu.md
///
///   1/2 rho(|e_r|^2/sigma_r^2) + 1/2 rho(|e_p|^2/sigma_p^2),   e the correction of the mount                      (3)
/// with Cauchy's rho: a calibration is right within its sigma, or it is of another rig, a drawing, mixed up, and then
/// says little. It never goes into the window's prior, so that its weight is always that of the mount as it is now.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

struct ExtrinsicsOptions {
  double rotation_sigma = 7e-4;    ///< of the calibration [rad]; 0: it is known
  double position_sigma = 2.5e-3;  ///< [m]; 0: it is known
  double doubt = 3;                ///< it is hardly believed beyond so many sigma
};

class ExtrinsicsPrior {
 public:
  using Correction = Vec<double, state::Extrinsics::dim>;

  explicit ExtrinsicsPrior(const ExtrinsicsOptions& options) : options_(options), loss_{options.doubt} {}

  /// The mount stays as it is, whatever the calibration says of it.
  void hold(bool held) { is_held_ = held; }

  double cost(const Correction& e) const { return (loss_.rho(squared(e, 0)) + loss_.rho(squared(e, position))) / 2; }

  /// To a block of the normal equations.
  void add_to(const Correction& e, int block, auto& normal) const {
    Mat<double, state::Extrinsics::dim, state::Extrinsics::dim> H;
    set_zero(H);
    Correction g;
    for (int k = 0; k < state::Extrinsics::dim; ++k) {
      const int part = k < position ? 0 : position;
      H(k, k) = loss_.weight(squared(e, part)) / (sigma(part) * sigma(part));
      g[k] = H(k, k) * e[k];
      if (is_held_) H(k, k) += 1 / (known * known);
    }
    normal.add_block(block, block, H);
    normal.add_gradient(block, g);
  }

 private:
  static constexpr int position = 3;     ///< where it begins
  static constexpr double known = 1e-6;  ///< sigma of what is [rad, m]

  double sigma(int part) const {
    return std::max(known, part == position ? options_.position_sigma : options_.rotation_sigma);
  }
  /// |e|^2/sigma^2 of one part.
  double squared(const Correction& e, int part) const {
    return squared_norm(segment<3>(e, part)) / (sigma(part) * sigma(part));
  }

  ExtrinsicsOptions options_;
  Cauchy<double> loss_;
  bool is_held_ = false;
};

}  // namespace plumbline
