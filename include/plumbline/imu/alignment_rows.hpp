#pragma once
/// Rows of the visual-inertial alignment for one interval between two camera poses, whitened by the covariance of the
/// increment plus that of the poses.                                        docs/math/initialization.md (7), (7a)

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/imu/alignment_frame.hpp"
#include "plumbline/imu/alignment_options.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/velocity_chain.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// Offsets of the unknowns common to all frames: g', lambda, b'.
struct AlignmentUnknowns {
  enum : int { g = 0, lambda = 3, b_a = 4, count = 7 };
};

/// Adds the whitened rows (7) of one interval, about the accelerometer bias of its increment; false when the covariance
/// is not positive definite.
template <int MaxFrames, class P>
bool add_alignment_rows(VelocityChain<MaxFrames, AlignmentUnknowns::count>& chain, const AlignmentFrame<P>& begin,
                        const AlignmentFrame<P>& end, const SE3<double>& T_body_cam, double lambda,
                        const InertialAlignmentOptions& options) {
  using Vec3 = Vec<double, 3>;
  using Mat3 = Mat<double, 3, 3>;
  const auto& d = end.imu->increment();
  const double t = double(d.duration);
  const Vec3 dp = cast_to<double>(d.delta.dp), dv = cast_to<double>(d.delta.dv);
  const Vec3 bias = cast_to<double>(d.bias_accel), p_body_cam = T_body_cam.p();
  const Mat3 J_p_a = cast_to<double>(d.J_p_a()), J_v_a = cast_to<double>(d.J_v_a());
  const SE3<double> T_i = begin.T_ref_cam.template cast<double>(), T_j = end.T_ref_cam.template cast<double>();
  const SO3<double> R_i_ref = T_body_cam.rotation() * T_i.rotation().inverse();
  const SO3<double> R_i_j = R_i_ref * T_j.rotation() * T_body_cam.rotation().inverse();
  const Mat3 Rt = R_i_ref.matrix(), t_Rt = t * Rt;

  Mat<double, 6, 3> A_begin, A_end;
  set_block(A_begin, 0, 0, t_Rt);
  set_block(A_begin, 3, 0, Rt);
  set_zero(A_end);
  set_block(A_end, 3, 0, Mat3(-Rt));
  Mat<double, 6, AlignmentUnknowns::count> B;
  set_block(B, 0, AlignmentUnknowns::g, Mat3(0.5 * t * t_Rt));
  set_block(B, 3, AlignmentUnknowns::g, t_Rt);
  set_block(B, 0, AlignmentUnknowns::lambda, Vec3(dp + R_i_j * p_body_cam - p_body_cam - J_p_a * bias));
  set_block(B, 3, AlignmentUnknowns::lambda, Vec3(dv - J_v_a * bias));
  set_block(B, 0, AlignmentUnknowns::b_a, J_p_a);
  set_block(B, 3, AlignmentUnknowns::b_a, J_v_a);
  Vec<double, 6> c;
  set_zero(c);
  set_segment(c, 0, Vec3(R_i_ref * Vec3(T_j.p() - T_i.p())));

  Mat<double, 6, 3> J_rotation;  // D of (7a)
  set_block(J_rotation, 0, 0, hat(dp));
  set_block(J_rotation, 3, 0, hat(dv));
  Mat<double, 6, 6> variance = product_transposed(J_rotation, J_rotation);
  variance = (options.rotation_sigma * options.rotation_sigma) * variance;
  variance += cast_to<double>(block<6, 6>(d.covariance, 3, 3));
  constexpr double variance_floor = 1e-12;  // numerics: S stays regular
  for (int k = 0; k < 6; ++k) variance(k, k) += variance_floor;
  variance = (lambda * lambda) * variance;
  const Mat3 noise_end = product(R_i_j.matrix(), cast_to<double>(end.position_covariance));
  const Mat3 noise = cast_to<double>(begin.position_covariance) + product_transposed(noise_end, R_i_j.matrix());
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) variance(i, k) += noise(i, k);
    variance(k, k) += 2 * options.position_sigma * options.position_sigma;
  }
  const Result<Mat<double, 6, 6>> L = square_root_information(variance);
  if (!L) return false;
  chain.add_interval(product(*L, A_begin), product(*L, A_end), product(*L, B), product(*L, c));
  return true;
}

}  // namespace plumbline
