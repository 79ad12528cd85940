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
#include <cstdint>
#include <limits>
#include <span>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/imu/alignment_frame.hpp"
#include "plumbline/imu/gravity.hpp"
#include "plumbline/imu/gyro_bias.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/imu/nav_state.hpp"
#include "plumbline/imu/velocity_chain.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

struct InertialAlignmentOptions {
  bool metric = false;           ///< the positions of the camera poses are in meters; set by the initializer
  double rotation_sigma = 2e-3;  ///< sigma of the rotation of a camera pose [rad]; tuned: docs/decisions/132 (chosen)
  /// Sigma of the position of a camera pose besides its own covariance, in units of the poses;
  /// tuned: docs/decisions/023.
  double position_sigma = 2e-3;
  double accel_bias_sigma = 0.2;  ///< prior sigma of the accelerometer bias [m/s^2]; tuned: docs/decisions/024
  std::size_t min_frames = 5;     ///< smallest number of frames; numerics: 4 determine the unknowns
  /// Largest rms rotation between camera and gyroscope after the bias is estimated [rad];
  /// tuned: docs/decisions/132 (chosen).
  double max_gyro_residual = 0.02;
  double max_chi2 = 3;  ///< largest chi2 per degree of freedom; below 1 for consistent poses; tuned: docs/decisions/023
  /// Largest error of the norm of free gravity, relative, besides three of its sigmas;
  /// tuned: docs/decisions/132 (chosen).
  double max_gravity_error = 0.1;
  double max_gravity_sigma = 0.05;  ///< largest sigma of the direction of gravity [rad]; tuned: docs/decisions/023
  double max_scale_sigma = 0.1;     ///< largest sigma of the scale, relative; tuned: docs/decisions/023
};

/// Result of an alignment, or the reason why there is none.
enum class AlignmentOutcome : std::uint8_t {
  aligned,
  too_few_frames,
  no_imu_data,          ///< an increment is empty or not finite
  rotations_disagree,   ///< of camera and gyroscope: wrong poses, extrinsics or time stamps
  positions_disagree,   ///< of camera and accelerometer: the scale of the poses has drifted, or they are wrong
  gravity_implausible,  ///< norm of gravity: wrong poses, units or extrinsics
  gravity_uncertain,    ///< direction of gravity not determined yet
  scale_uncertain,      ///< scale not determined yet: it needs accelerated motion
};

/// For logs.
constexpr const char* name_of(AlignmentOutcome outcome) {
  switch (outcome) {
    case AlignmentOutcome::aligned: return "aligned";
    case AlignmentOutcome::too_few_frames: return "too few frames";
    case AlignmentOutcome::no_imu_data: return "no IMU data";
    case AlignmentOutcome::rotations_disagree: return "camera and gyroscope turn differently";
    case AlignmentOutcome::positions_disagree: return "camera and accelerometer move differently";
    case AlignmentOutcome::gravity_implausible: return "gravity of a wrong length";
    case AlignmentOutcome::gravity_uncertain: return "gravity uncertain";
    case AlignmentOutcome::scale_uncertain: return "scale uncertain";
  }
  return "unknown outcome";
}

/// Whether poses and IMU samples contradict each other: no motion, gravity and biases explain both.
constexpr bool contradicts(AlignmentOutcome outcome) {
  return outcome == AlignmentOutcome::rotations_disagree || outcome == AlignmentOutcome::positions_disagree ||
         outcome == AlignmentOutcome::gravity_implausible;
}

/// Result of the alignment.
template <std::floating_point S, int MaxFrames>
struct InertialAlignment {
  AlignmentOutcome outcome = AlignmentOutcome::too_few_frames;
  SO3<S> R_world_ref;
  S scale = S(1);  ///< meters in one unit of the camera poses
  Vec<S, 3> bias_gyro = zeros<S, 3>(), bias_accel = zeros<S, 3>();
  FixedVector<Vec<S, 3>, std::size_t(MaxFrames)> v_world_body;  ///< for each frame [m/s]
  // Figures, up to the step that was reached:
  double gyro_residual = 0;     ///< rms rotation between camera and gyroscope [rad]
  double excitation = 0;        ///< rms change of the specific force between frames [m/s^2]
  double gravity_norm = 0;      ///< norm of gravity while it is free [m/s^2]
  double gravity_sigma = 0;     ///< sigma of the direction of gravity [rad]
  double scale_sigma = 0;       ///< sigma of the scale, relative
  double accel_bias_sigma = 0;  ///< largest sigma of the accelerometer bias over the axes [m/s^2]
  double chi2 = 0;              ///< per degree of freedom; the sigmas above are multiplied by its square root if > 1

  explicit operator bool() const { return outcome == AlignmentOutcome::aligned; }
  /// Whether all quantities were estimated, but gravity or scale with a large sigma.
  bool is_uncertain() const {
    return !v_world_body.empty() &&
           (outcome == AlignmentOutcome::gravity_uncertain || outcome == AlignmentOutcome::scale_uncertain);
  }
  bool contradicts() const { return plumbline::contradicts(outcome); }

  /// State of frame k. The world has the origin of `ref`.
  NavState<S> state(std::size_t k, const SE3<S>& T_ref_cam, const SE3<S>& T_body_cam) const {
    const SE3<S> T_world_cam(R_world_ref * T_ref_cam.rotation(), R_world_ref * Vec<S, 3>(scale * T_ref_cam.p()));
    return {T_world_cam * T_body_cam.inverse(), v_world_body[k], bias_gyro, bias_accel};
  }
};

namespace detail {

/// Offsets of the unknowns common to all frames: g', lambda, b'.
struct AlignmentUnknowns {
  enum : int { g = 0, lambda = 3, b_a = 4, count = 7 };
};

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

}  // namespace detail

/// Aligns at most MaxFrames frames in order of time. The preintegrations of the frames are reintegrated about the
/// estimated biases.
template <int MaxFrames, class P>
InertialAlignment<typename P::Scalar, MaxFrames> align_inertial(std::span<const AlignmentFrame<P>> frames,
                                                                const SE3<typename P::Scalar>& T_body_cam,
                                                                const InertialAlignmentOptions& options = {},
                                                                double gravity = standard_gravity<double>) {
  using S = typename P::Scalar;
  using Unknowns = detail::AlignmentUnknowns;
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
      if (!detail::add_alignment_rows(chain, frames[k - 1], frames[k], T_body_camera, lambda, options))
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
