#pragma once
/// Visual-inertial alignment in closed form: velocities, gravity, biases and, for up-to-scale poses, the scale, from
/// camera poses and preintegrated IMU increments.                                           docs/math/initialization.md
///
/// Let `ref` be the frame of the camera poses, R_k the rotation of the body and c_k the position of the camera in it,
/// p_e the position of the camera in the body. The equations are linear in lambda, the length of a meter in units of
/// the poses, and in V_k, g', b': velocities, gravity, accelerometer bias, each times lambda:
///   Dt R_k^T V_k + Dt^2/2 R_k^T g' + (dp_k + R_k^T R_{k+1} p_e - p_e) lambda + J_p_a b' = R_k^T (c_{k+1} - c_k)
///   R_k^T V_k - R_k^T V_{k+1} + Dt R_k^T g' + dv_k lambda + J_v_a b' = 0                                         (7)
/// The positions, by far the noisiest quantities, are on the right-hand side: noise in a coefficient would bias the
/// scale towards zero. Steps:
///   1. gyroscope bias, (5)
///   2. g' free, b' = 0: the norm of g' / lambda is compared with G, a check of poses and IMU
///   3. |g| = G on its tangent, g^T g' = G lambda, with a prior on b'; repeated from the direction found            (8)
///   4. gravity in `ref` gives the attitude of the world, (2), with zero yaw of the first body
/// Metric poses have the row lambda = 1. Rows are whitened by the covariance of the increment plus that of the poses,
/// (7a).

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/alignment_frame.hpp"
#include "plumbline/imu/alignment_options.hpp"
#include "plumbline/imu/alignment_result.hpp"
#include "plumbline/imu/alignment_rows.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/gyro_bias.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/velocity_chain.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

namespace detail {

/// Mean and deviation of the specific forces between frames, in `ref` [m/s^2].
struct SpecificForce {
  Vec<double, 3> mean = zeros<double, 3>();
  double deviation = 0;  ///< root mean square deviation from the mean
};

template <class P>
SpecificForce specific_force(std::span<const AlignmentFrame<P>> frames, const SO3<double>& R_cam_body) {
  SpecificForce out;
  double squared = 0, n = 0;
  for (std::size_t k = 1; k < frames.size(); ++k) {
    const auto& d = frames[k].imu->increment();
    const SO3<double> R = frames[k - 1].T_ref_cam.rotation().template cast<double>() * R_cam_body;
    const Vec<double, 3> f = R * Vec<double, 3>(cast_to<double>(d.delta.dv) / double(d.duration));
    const Vec<double, 3> step = f - out.mean;
    out.mean += step / ++n;
    squared += dot(step, f - out.mean);
  }
  out.deviation = std::sqrt(squared / n);
  return out;
}

}  // namespace detail

/// Aligns at most MaxFrames frames in order of time. The preintegrations of the frames are reintegrated about the
/// estimated biases.
template <int MaxFrames, class P>
InertialAlignment<typename P::Scalar, MaxFrames> align_inertial(std::span<const AlignmentFrame<P>> frames,
                                                                const SE3<typename P::Scalar>& T_body_cam,
                                                                const InertialAlignmentOptions& options = {},
                                                                double gravity = standard_gravity<double>) {
  using S = typename P::Scalar;
  using Unknowns = AlignmentUnknowns;
  using Row = Mat<double, 1, Unknowns::count>;
  PLUMBLINE_ASSERT(frames.size() <= std::size_t(MaxFrames));
  InertialAlignment<S, MaxFrames> out;
  const auto stop = [&](AlignmentOutcome outcome) {
    out.outcome = outcome;
    return out;
  };
  constexpr std::size_t solvable = 4;  // with fewer there are more unknowns than rows
  if (frames.size() < options.min_frames || frames.size() < solvable) return stop(AlignmentOutcome::too_few_frames);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (frames[k].imu == nullptr || !(frames[k].imu->increment().duration > S(0)) ||
        !all_finite(frames[k].imu->increment().covariance))
      return stop(AlignmentOutcome::no_imu_data);
  }
  const SE3<double> T_body_camera = T_body_cam.template cast<double>();
  const GyroBias gyro = estimate_gyro_bias<P>(frames, T_body_cam.rotation(), options.rotation_sigma);
  out.gyro_residual = gyro.residual;
  if (!gyro.valid || !(gyro.residual <= options.max_gyro_residual)) return stop(AlignmentOutcome::rotations_disagree);
  out.bias_gyro = cast_to<S>(gyro.bias);
  const detail::SpecificForce force = detail::specific_force<P>(frames, T_body_camera.rotation().inverse());
  out.excitation = force.deviation;
  // Degrees of freedom: 6 rows an interval, three of b', those of (8) and metric; less velocities and common unknowns.
  const double freedom = 6 * double(frames.size() - 1) + 3 - 3 * double(frames.size()) - int(Unknowns::count);

  Vec<double, 3> g = zeros<double, 3>();
  double lambda = 1;
  VelocityChain<MaxFrames, Unknowns::count> chain;
  constexpr int free_rounds = 2, rounds = 7;       // numerics: the weights depend on lambda
  constexpr double pinned = 1e6, on_sphere = 1e4;  // weights, 1/sigma; numerics: constraints
  constexpr double gate_sigmas = 3;                // chi-square quantile 99.7 %, 1 degree of freedom
  for (int round = 0; round < rounds; ++round) {
    const bool free = round < free_rounds;
    const auto add_prior = [&](int k, double weight, double value) {
      Row row = zeros<Row>();
      row[k] = weight;
      chain.add_common_row(row, weight * value);
    };
    chain.clear();
    if (options.metric) add_prior(Unknowns::lambda, pinned, 1);
    for (int i = 0; i < 3; ++i)
      add_prior(Unknowns::b_a + i, (free ? pinned : 1 / options.accel_bias_sigma) / lambda, 0);
    if (!free) {  // (8)
      const double weight = on_sphere / lambda;
      Row row = zeros<Row>();
      for (int i = 0; i < 3; ++i) row[Unknowns::g + i] = weight * g[i] / norm(g);
      row[Unknowns::lambda] = -weight * gravity;
      chain.add_common_row(row, 0);
    }
    for (std::size_t k = 1; k < frames.size(); ++k) {
      if (!add_alignment_rows(chain, frames[k - 1], frames[k], T_body_camera, lambda, options))
        return stop(AlignmentOutcome::scale_uncertain);
    }
    if (!chain.solve()) return stop(AlignmentOutcome::scale_uncertain);
    const double signed_lambda = chain.common()[Unknowns::lambda];
    g = segment<3>(chain.common(), Unknowns::g) / signed_lambda;
    lambda = std::abs(signed_lambda);
    if (round == free_rounds - 1) {
      out.gravity_norm = norm(g);
      Vec<double, Unknowns::count> J = zeros<double, Unknowns::count>();  // of |g' / lambda|
      for (int i = 0; i < 3; ++i) J[Unknowns::g + i] = g[i] / (out.gravity_norm * signed_lambda);
      J[Unknowns::lambda] = -out.gravity_norm / signed_lambda;
      const double chi2 = chain.cost() / (freedom + (options.metric ? 1 : 0));
      const double sigma = std::sqrt(std::max(1.0, chi2) * quadratic_form(chain.covariance(), J));
      const double error = std::abs(out.gravity_norm - gravity);
      if (!(error <= options.max_gravity_error * gravity + gate_sigmas * sigma))
        return stop(AlignmentOutcome::gravity_implausible);
      // With little acceleration the mean specific force gives the vertical better than the positions.
      if (!(error <= options.max_gravity_error * gravity)) g = -gravity * normalized(force.mean);
    }
  }

  out.chi2 = chain.cost() / (freedom + (options.metric ? 2 : 1));
  const Mat<double, 7, 7> covariance = chain.covariance();
  const double inflation = std::max(1.0, out.chi2);
  const auto variance = [&](int k) { return inflation * covariance(k, k); };
  const Mat<double, 3, 3> across = hat(normalized(g));  // |across dg| is the part of dg normal to g
  const Mat<double, 3, 3> tilt = product_transposed(product(across, inflation * block<3, 3>(covariance, 0, 0)), across);
  out.gravity_sigma = std::sqrt(tilt.trace()) / (lambda * gravity);
  out.scale_sigma = std::sqrt(variance(Unknowns::lambda)) / lambda;
  constexpr int b = Unknowns::b_a;
  out.accel_bias_sigma = std::sqrt(std::max({variance(b), variance(b + 1), variance(b + 2)})) / lambda;

  const SO3<double> R_ref_body =
      frames[0].T_ref_cam.rotation().template cast<double>() * T_body_camera.rotation().inverse();
  const SO3<double> R_world_ref = upright<double>(R_ref_body.inverse() * g) * R_ref_body.inverse();
  out.R_world_ref = R_world_ref.template cast<S>();
  out.scale = S(1 / lambda);
  const Vec<double, 3> bias_accel = segment<3>(chain.common(), Unknowns::b_a) / lambda;
  out.bias_accel = cast_to<S>(bias_accel);
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Vec<double, 3> v_world_body = R_world_ref * Vec<double, 3>(chain.velocity(int(k)) / lambda);
    out.v_world_body.push_back(cast_to<S>(v_world_body));
  }
  for (std::size_t k = 1; k < frames.size(); ++k) frames[k].imu->reintegrate(out.bias_gyro, out.bias_accel);

  if (!(out.chi2 <= options.max_chi2)) return stop(AlignmentOutcome::positions_disagree);
  if (!(chain.common()[Unknowns::lambda] > 0)) out.scale_sigma = std::numeric_limits<double>::infinity();
  if (!(out.gravity_sigma <= options.max_gravity_sigma)) return stop(AlignmentOutcome::gravity_uncertain);
  if (options.metric) return stop(AlignmentOutcome::aligned);
  if (!(out.scale_sigma <= options.max_scale_sigma)) return stop(AlignmentOutcome::scale_uncertain);
  return stop(AlignmentOutcome::aligned);
}

}  // namespace plumbline
