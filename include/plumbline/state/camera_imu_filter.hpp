#pragma once
/// Kalman filter of the time offset of the camera and of the rotation of its extrinsics, from the orientations of
/// camera and gyroscope before initialization.                                                  docs/math/camera_imu.md
///
/// R_g is the orientation of the body propagated by the gyroscope, R_v the orientation by vision; each has a world of
/// its own. With a time offset wrong by d, extrinsics wrong by phi (R_body_cam = Exp(phi) R_calibrated), a gyroscope
/// bias wrong by b, and the body rotating at w:
///   R_v = Exp(c) R_g Exp(phi + w d),   c+ = c + R_g J_R_g b                                                      (1)
///   e = Log(R_g^T R_v) = R_g^T c + phi + w d + noise,   H = [R_g^T 0 I w]                                        (2)
/// The variance of the noise includes (w' (d^2 + sigma_d^2)/2)^2, the change of w over d. The state is [c b phi d], ten
/// numbers [rad, rad/s, rad, s]. R_g and the bias are corrected by every update, so that c and b are errors with mean
/// zero. The offset is corrected only when d is significant (`take_time_offset`); phi is reported, not applied. After
/// initialization the window estimates extrinsics and offset (backend/extrinsics_prior.hpp,
/// backend/time_offset_prior.hpp).

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

struct CameraImuOptions {
  /// Prior sigma of the calibrated time offset [s]; 0: the offset is fixed; tuned: docs/decisions/028.
  double time_offset_sigma_s = 0.04;
  /// Prior sigma of the calibrated rotation of the extrinsics [rad]; 0: it is fixed;
  /// tuned: docs/decisions/133 (chosen).
  double rotation_sigma = 0.03;
  /// The offset counts as wrong when its error exceeds this many of its sigmas; tuned: docs/decisions/133 (chosen).
  double detection_sigmas = 4;
  /// Largest sigma of the offset with which it is corrected [s]; tuned: docs/decisions/133 (chosen).
  double max_detection_sigma_s = 0.01;
  /// Smallest error of the offset that counts as wrong [s]; tuned: docs/decisions/133 (chosen).
  double min_error_s = 1e-3;
  /// An offset that counts as wrong is corrected beyond this many sigmas; tuned: docs/decisions/133 (chosen).
  double correction_sigmas = 1;
  /// Largest correction of the offset in one frame [s]; tuned: docs/decisions/133 (chosen).
  double max_step_s = 0.01;
  /// Largest sum of all corrections of the offset [s]; tuned: docs/decisions/133 (chosen).
  double max_correction_s = 0.15;
  /// Sigma that a correction adds to the offset, as a fraction of the correction; tuned: docs/decisions/028.
  double step_error = 0.2;
  /// Typical angular acceleration of the body [rad/s^2]; tuned: docs/decisions/133 (chosen).
  double angular_acceleration = 2;
  /// Prior sigma of the gyroscope bias [rad/s]; tuned: docs/decisions/133 (chosen).
  double bias_sigma = 0.1;
  /// Random walk of the gyroscope bias [rad/s/sqrt(s)]; tuned: docs/decisions/133 (chosen).
  double bias_walk = 1e-3;
  /// Sigma of the orientation by vision besides the noise of its features [rad]; tuned: docs/decisions/133 (chosen).
  double vision_sigma = 7e-4;
  /// Random walk of the world of vision against that of the gyroscope [rad/sqrt(s)];
  /// tuned: docs/decisions/133 (chosen).
  double drift = 1.5e-3;
  double time_offset_walk = 5e-5;  ///< random walk of the offset [s/sqrt(s)]; tuned: docs/decisions/133 (chosen)
  /// Random walk of the rotation of the extrinsics [rad/sqrt(s)]; tuned: docs/decisions/133 (chosen).
  double rotation_walk = 5e-5;
  /// Gate of an orientation by vision [sigma]; tuned: docs/decisions/133 (chosen).
  double innovation_gate = 5;
  /// Orientations in a row that must pass the gate before the offset is corrected; swapped axes do not pass;
  /// tuned: docs/decisions/133 (chosen).
  int min_consecutive = 10;
  /// Orientations rejected in a row after which world and bias are reset; tuned: docs/decisions/133 (chosen).
  int max_rejected = 10;
};

class CameraImuFilter {
 public:
  using Vec3 = Vec<double, 3>;
  using Mat3 = Mat<double, 3, 3>;

  CameraImuFilter() = default;
  explicit CameraImuFilter(const CameraImuOptions& options) : options_(options) {
    reset(bias, options.bias_sigma);
    reset_extrinsics();
    P_(offset, offset) = options.time_offset_sigma_s * options.time_offset_sigma_s;
  }

  double time_offset_error() const { return d_; }      ///< d: estimated error, not corrected yet [s]
  const Vec3& rotation_error() const { return phi_; }  ///< phi, R_body_cam = Exp(phi) R_calibrated [rad]
  /// Whether the calibrated time offset was found to be wrong.
  bool is_time_offset_wrong() const { return is_time_offset_wrong_; }
  /// Standard deviation of the time offset [s].
  double time_offset_sigma() const { return std::sqrt(P_(offset, offset)); }
  /// Largest standard deviation of phi over the three axes [rad].
  double rotation_sigma() const {
    return std::sqrt(
        std::max({P_(extrinsics, extrinsics), P_(extrinsics + 1, extrinsics + 1), P_(extrinsics + 2, extrinsics + 2)}));
  }
  /// Whether the offset in use is consistent with the estimate (within one sigma), or its sigma is below `sigma_s` [s].
  bool accepts_time_offset(double sigma_s) const {
    constexpr double gate_sigmas = 1;  // tuned: docs/decisions/027
    return time_offset_sigma() < sigma_s || std::abs(d_) < gate_sigmas * time_offset_sigma();
  }

  /// The next orientation by vision starts a new world: after a reset of vision, or when IMU samples are missing.
  void reset_world() { has_world_ = false; }
  /// Resets phi to its prior, when it was estimated with a wrong time offset or an inaccurate scene.
  void reset_extrinsics() {
    set_zero(phi_);
    reset(extrinsics, options_.rotation_sigma);
  }

  /// The time offset in use was increased by `step_s` [s] elsewhere.
  void shift_time_offset(double step_s) {
    d_ -= step_s;
    corrected_s_ += step_s;
    is_time_offset_wrong_ = is_time_offset_wrong_ || std::abs(corrected_s_) > options_.min_error_s;
  }
  /// The extrinsics in use were changed elsewhere: R_body_cam <- Exp(d) R_body_cam.
  void rotate_extrinsics(const Vec3& d) { phi_ -= d; }

  /// Propagation by the IMU increment since the previous frame.                                                  (1)
  template <class S>
  void propagate(const ImuIncrement<S>& since_frame) {
    const Mat3 J = cast_to<double>(since_frame.J_R_g());
    const Vec3 db = bias_ - cast_to<double>(since_frame.bias_gyro);
    R_g_ = R_g_ * since_frame.delta.dR.template cast<double>() * SO3<double>::exp(J * db);
    Mat<double, dim, dim> F = identity<double, dim>();
    set_block(F, world, bias, Mat3(R_g_.matrix() * J));
    P_ = product_transposed(product(F, P_), F);
    const auto walk = [&](int k, double density) { P_(k, k) += density * density * double(since_frame.duration); };
    for (int k = 0; k < 3; ++k) {
      walk(world + k, options_.drift);
      walk(bias + k, options_.bias_walk);
      if (options_.rotation_sigma > 0) walk(extrinsics + k, options_.rotation_walk);
    }
    if (options_.time_offset_sigma_s > 0) walk(offset, options_.time_offset_walk);
  }

  /// Update by the orientation of vision and its covariance [rad^2]; w: angular rate of the body [rad/s].        (2)
  void update(const SO3<double>& R_v, const Mat3& covariance, const Vec3& w) {
    if (!has_world_) return initialize_world(R_v, w);
    Mat<double, 3, dim> H = zeros<double, 3, dim>();
    set_block(H, 0, world, R_g_.inverse().matrix());
    for (int k = 0; k < 3; ++k) {
      H(k, extrinsics + k) = 1;
      H(k, offset) = w[k];
    }
    const Vec3 e = (R_g_.inverse() * R_v).log() - phi_ - d_ * w;
    const Mat<double, dim, 3> PHt = product_transposed(P_, H);
    const double second_order = 0.5 * options_.angular_acceleration * (d_ * d_ + P_(offset, offset));
    Mat3 V = product(H, PHt) + covariance;
    for (int k = 0; k < 3; ++k) V(k, k) += options_.vision_sigma * options_.vision_sigma + second_order * second_order;
    Mat3 V_inverse;
    if (!invert(V, V_inverse) || !(dot(e, V_inverse * e) <= options_.innovation_gate * options_.innovation_gate))
      return reject();
    rejected_ = 0;
    ++consecutive_;
    const Mat<double, dim, 3> K = product(PHt, V_inverse);
    const Vec<double, dim> x = product(K, e);
    const Mat<double, dim, dim> KHP = product_transposed(K, PHt);
    for (int c = 0; c < dim; ++c) {
      for (int r = 0; r <= c; ++r) P_(r, c) = P_(c, r) = 0.5 * ((P_(r, c) - KHP(r, c)) + (P_(c, r) - KHP(c, r)));
    }
    R_g_ = SO3<double>::exp(segment<3>(x, world)) * R_g_;
    bias_ += segment<3>(x, bias);
    phi_ += segment<3>(x, extrinsics);
    d_ += x[offset];
  }

  /// The correction of the time offset if it is significant, else 0 [s]. The caller applies it.
  double take_time_offset() {
    const double sigma = time_offset_sigma();
    if (consecutive_ < options_.min_consecutive || !(sigma < options_.max_detection_sigma_s)) return 0;
    const double least = is_time_offset_wrong_ ? options_.correction_sigmas * sigma
                                               : std::max(options_.min_error_s, options_.detection_sigmas * sigma);
    if (!(std::abs(d_) > least)) return 0;
    is_time_offset_wrong_ = true;
    reset_extrinsics();  // phi was estimated with the wrong offset
    const double wanted = corrected_s_ + std::clamp(d_, -options_.max_step_s, options_.max_step_s);
    const double step = std::clamp(wanted, -options_.max_correction_s, options_.max_correction_s) - corrected_s_;
    corrected_s_ += step;
    d_ -= step;
    P_(offset, offset) += options_.step_error * options_.step_error * step * step;
    return step;
  }

 private:
  static constexpr int world = 0, bias = 3, extrinsics = 6, offset = 9, dim = 10;

  void reset(int at, double sigma) {
    for (int k = at; k < at + 3; ++k) {
      for (int i = 0; i < dim; ++i) P_(k, i) = P_(i, k) = 0;
      P_(k, k) = sigma * sigma;
    }
  }
  /// The first orientation in a world of vision: sets R_g by (1) with c = 0.
  void initialize_world(const SO3<double>& R_v, const Vec3& w) {
    R_g_ = R_v * SO3<double>::exp(phi_ + d_ * w).inverse();
    reset(world, 1);
    has_world_ = true;
    rejected_ = 0;
  }
  void reject() {
    consecutive_ = 0;
    if (++rejected_ <= options_.max_rejected) return;
    reset(bias, options_.bias_sigma);
    reset_world();
  }

  CameraImuOptions options_;
  Mat<double, dim, dim> P_ = zeros<double, dim, dim>();  ///< covariance of [c b phi d]
  SO3<double> R_g_;
  Vec3 bias_ = zeros<Vec3>(), phi_ = zeros<Vec3>();
  double d_ = 0, corrected_s_ = 0;
  bool has_world_ = false, is_time_offset_wrong_ = false;
  int rejected_ = 0, consecutive_ = 0;  ///< orientations in a row beyond the gate, and within it
};

}  // namespace plumbline
