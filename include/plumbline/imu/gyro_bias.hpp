#pragma once
/// Gyroscope bias from the rotations of a camera between frames, by least squares.     docs/math/initialization.md
///
///   e_k = Log(dR_k^T R_k^T R_{k+1}),   R_k = R_ref_body = R_ref_cam R_body_cam^T
///   (sum J^T W J) db = sum J^T W e_k,   J = J_R_g,  W = (S_phi + 2 sigma^2 I)^-1                                  (5)
/// Three rounds, with re-integration about the new bias after each.

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <span>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/alignment_frame.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

struct GyroBias {
  bool valid = false;                        ///< enough frames, and a finite result
  Vec<double, 3> bias = zeros<double, 3>();  ///< [rad/s]
  double residual = 0;                       ///< rms of e_k [rad]
};

/// (5). The preintegrations of the frames are reintegrated about the result. `rotation_sigma`: sigma of a camera
/// rotation [rad].
template <class P>
GyroBias estimate_gyro_bias(std::span<const AlignmentFrame<P>> frames, const SO3<typename P::Scalar>& R_body_cam,
                            double rotation_sigma) {
  using S = typename P::Scalar;
  GyroBias out;
  if (frames.size() < 2) return out;
  const SO3<double> R_cam_body = R_body_cam.inverse().template cast<double>();
  constexpr int rounds = 3;                        // numerics: (5) is linear in the bias about the last one
  constexpr double variance_floor = 1e-12;         // numerics: the variance stays regular
  for (int round = 0; round <= rounds; ++round) {  // the last one gives the residual
    Mat<double, 3, 3> H = zeros<double, 3, 3>();
    Vec<double, 3> b = zeros<double, 3>();
    double squared = 0;
    for (std::size_t k = 1; k < frames.size(); ++k) {
      const ImuIncrement<S>& d = frames[k].imu->increment();
      const SO3<double> R_i = frames[k - 1].T_ref_cam.rotation().template cast<double>() * R_cam_body;
      const SO3<double> R_j = frames[k].T_ref_cam.rotation().template cast<double>() * R_cam_body;
      const Vec<double, 3> e = (d.delta.dR.template cast<double>().inverse() * R_i.inverse() * R_j).log();
      const Mat<double, 3, 3> J = cast_to<double>(d.J_R_g());
      Mat<double, 3, 3> variance = cast_to<double>(block<3, 3>(d.covariance, 0, 0));
      for (int i = 0; i < 3; ++i) variance(i, i) += 2 * rotation_sigma * rotation_sigma + variance_floor;
      const Mat<double, 3, 3> W = variance.inverse(), Jt_W = J.transpose() * W;
      const Vec<double, 3> bias = cast_to<double>(d.bias_gyro);
      H += Jt_W * J;
      b += Jt_W * Vec<double, 3>(e + J * bias);
      squared += squared_norm(e);
    }
    out.residual = std::sqrt(squared / static_cast<double>(frames.size() - 1));
    if (round == rounds) break;
    Mat<double, 3, 3> H_inverse;
    if (!invert(H, H_inverse)) return out;
    out.bias = H_inverse * b;
    if (!all_finite(out.bias)) return out;
    for (std::size_t k = 1; k < frames.size(); ++k)
      frames[k].imu->reintegrate(cast_to<S>(out.bias), frames[k].imu->increment().bias_accel);
  }
  out.valid = std::isfinite(out.residual);
  return out;
}

}  // namespace plumbline
