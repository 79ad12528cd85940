#pragma once
/// Prior on the extrinsics of the camera from the calibration.                            docs/math/camera_imu.md
///
///   1/2 rho(|e_r|^2/sigma_r^2) + 1/2 rho(|e_p|^2/sigma_p^2),   e = [e_r; e_p] the correction of the extrinsics    (3)
/// with Cauchy's rho: a calibration is right within its sigma, or it belongs to another rig and has no information. The
/// term is never marginalized, so that its weight is always that at the present extrinsics.

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/state/block.hpp"

namespace plumbline {

struct ExtrinsicsOptions {
  /// Prior sigma of the calibrated rotation [rad]; 0: the rotation is fixed; tuned: docs/decisions/030.
  double rotation_sigma = 7e-4;
  /// Prior sigma of the calibrated position [m]; 0: the position is fixed; tuned: docs/decisions/030.
  double position_sigma = 2.5e-3;
  double cauchy_scale = 3;  ///< Cauchy scale of both parts [sigma]; tuned: docs/decisions/030
};

class ExtrinsicsPrior {
 public:
  using Correction = Vec<double, state::Extrinsics::dim>;

  explicit ExtrinsicsPrior(const ExtrinsicsOptions& options) : options_(options), loss_{options.cauchy_scale} {}

  /// Holds the extrinsics at their present value, while `held` is true.
  void hold(bool held) { is_held_ = held; }

  /// (3)
  double cost(const Correction& e) const { return (loss_.rho(squared(e, 0)) + loss_.rho(squared(e, position))) / 2; }

  /// Adds gradient and Hessian of (3) at e to a block of the normal equations.
  void add_to(const Correction& e, int block, auto& normal) const {
    Mat<double, state::Extrinsics::dim, state::Extrinsics::dim> H;
    set_zero(H);
    Correction g;
    for (int k = 0; k < state::Extrinsics::dim; ++k) {
      const int part = k < position ? 0 : position;
      H(k, k) = loss_.weight(squared(e, part)) / (sigma(part) * sigma(part));
      g[k] = H(k, k) * e[k];
      if (is_held_) H(k, k) += 1 / (fixed_sigma * fixed_sigma);
    }
    normal.add_block(block, block, H);
    normal.add_gradient(block, g);
  }

 private:
  static constexpr int position = 3;           ///< offset of e_p in e
  static constexpr double fixed_sigma = 1e-6;  ///< sigma of fixed or held extrinsics [rad, m]; numerics: regular

  double sigma(int part) const {
    return std::max(fixed_sigma, part == position ? options_.position_sigma : options_.rotation_sigma);
  }
  /// |e|^2/sigma^2 of rotation (part 0) or position.
  double squared(const Correction& e, int part) const {
    return squared_norm(segment<3>(e, part)) / (sigma(part) * sigma(part));
  }

  ExtrinsicsOptions options_;
  Cauchy<double> loss_;
  bool is_held_ = false;
};

}  // namespace plumbline
