#pragma once
/// How camera and IMU stand to each other, from how both turn: the camera's clock (time offset), and the rotation of
/// its mount.                                                                         docs/math/camera_imu.md
///
/// The orientation R_g that the readings carry on, and R_v that images tell, are both of the body, each in a world of
/// its own. With a time offset wrong by d, a mount by phi, a gyroscope bias by b, and the body turning at w:
///   R_v = Exp(c) R_g Exp(phi + w d),   c+ = c + R_g J_R_g b                                                      (1)
///   e = Log(R_g^T R_v) = R_g^T c + phi + w d + noise,   its variance with (|w'| d^2/2)^2: w changes meanwhile    (2)
/// A Kalman filter over [c b phi d]. c and b are taken over at every step; d waits until it is beyond doubt, so that a
/// clock that is right stays as it is; phi is only told. Once frames and readings are solved for together, the window
/// finds mount and clock (backend/extrinsics_prior.hpp, backend/time_offset_prior.hpp).

#include <algorithm>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

struct CameraImuOptions {
  double time_offset_sigma_s = 0.04;  ///< of the calibration; 0: it is known
  double rotation_sigma = 0.03;       ///< the same of the mount [rad]
  double doubt = 4;                   ///< the clock is wrong beyond so many sigma
  double max_doubt_s = 0.01;          ///< if that sigma is less,
  double min_error_s = 1e-3;          ///< and if it is by more
  double trust = 1;                   ///< one that was found to be wrong is corrected beyond so many,
  double max_step_s = 0.01;           ///< of the clock, in one frame
  double max_correction_s = 0.15;     ///< of the clock, in all
  double step_error = 0.2;            ///< part of a correction of the clock that remains in doubt
  double angular_acceleration = 2;    ///< usual [rad/s^2]
  double bias_sigma = 0.1;            ///< of the gyroscope, when nothing is known of it [rad/s]
  double bias_walk = 1e-3;            ///< [rad/s/sqrt(s)]
  double vision_sigma = 7e-4;         ///< of vision's orientation, beyond the features' noise [rad]
  double drift = 1.5e-3;              ///< of vision's world against the gyroscope's [rad/sqrt(s)]
  double time_offset_walk = 5e-5;     ///< [s/sqrt(s)]
  double rotation_walk = 5e-5;        ///< [rad/sqrt(s)]
  double max_innovation = 5;          ///< of an orientation [sigma]; others are left out
  int min_in_a_row = 10;              ///< that fit, before the clock is corrected: axes might be swapped
  int max_left_out = 10;              ///< in a row, then worlds and bias are looked for anew
};

class CameraImuFilter {
 public:
  using Vec3 = Vec<double, 3>;
  using Mat3 = Mat<double, 3, 3>;

  CameraImuFilter() = default;
  explicit CameraImuFilter(const CameraImuOptions& options) : options_(options) {
    forget(bias, options.bias_sigma);
    forget_mount();
    P_(clock, clock) = options.time_offset_sigma_s * options.time_offset_sigma_s;
  }

  double time_offset_error() const { return d_; }      ///< found, not corrected yet [s]
  const Vec3& rotation_error() const { return phi_; }  ///< R_body_cam is Exp(phi) that of the calibration [rad]
  /// Whether it was found that the clock is not as it was calibrated.
  bool clock_is_wrong() const { return clock_is_wrong_; }
  double time_offset_sigma() const { return std::sqrt(P_(clock, clock)); }
  double rotation_sigma() const {
    return std::sqrt(std::max({P_(mount, mount), P_(mount + 1, mount + 1), P_(mount + 2, mount + 2)}));
  }
  /// Whether nothing speaks against the clock so far, or it is known that well.
  bool believes_clock(double sigma_s) const {
    constexpr double unremarkable = 1;
    return time_offset_sigma() < sigma_s || std::abs(d_) < unremarkable * time_offset_sigma();
  }

  /// Vision has another world from now on, or readings are missing.
  void forget_world() { has_world_ = false; }
  /// What was found of the mount was found by a vision that knew its scene, or its time, too little.
  void forget_mount() {
    set_zero(phi_);
    forget(mount, options_.rotation_sigma);
  }

  /// From now on the clock's offset is believed to be so much more [s].
  void turn_clock(double step_s) {
    d_ -= step_s;
    corrected_s_ += step_s;
    clock_is_wrong_ = clock_is_wrong_ || std::abs(corrected_s_) > options_.min_error_s;
  }
  /// From now on R_body_cam is believed to be Exp(d) what it was.
  void turn_mount(const Vec3& d) { phi_ -= d; }

  /// The readings since the frame before.                                                                        (1)
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
      if (options_.rotation_sigma > 0) walk(mount + k, options_.rotation_walk);
    }
    if (options_.time_offset_sigma_s > 0) walk(clock, options_.time_offset_walk);
  }

  /// Vision's orientation with its covariance, the body turning at w [rad/s].                                    (2)
  void update(const SO3<double>& R_v, const Mat3& covariance, const Vec3& w) {
    if (!has_world_) return meet(R_v, w);
    Mat<double, 3, dim> H = zeros<double, 3, dim>();
    set_block(H, 0, world, R_g_.inverse().matrix());
    for (int k = 0; k < 3; ++k) {
      H(k, mount + k) = 1;
      H(k, clock) = w[k];
    }
    const Vec3 e = (R_g_.inverse() * R_v).log() - phi_ - d_ * w;
    const Mat<double, dim, 3> PHt = product_transposed(P_, H);
    const double second_order = 0.5 * options_.angular_acceleration * (d_ * d_ + P_(clock, clock));
    Mat3 V = product(H, PHt) + covariance;
    for (int k = 0; k < 3; ++k) V(k, k) += options_.vision_sigma * options_.vision_sigma + second_order * second_order;
    Mat3 V_inverse;
    if (!invert(V, V_inverse) || !(dot(e, V_inverse * e) <= options_.max_innovation * options_.max_innovation))
      return leave_out();
    left_out_ = 0;
    ++in_a_row_;
    const Mat<double, dim, 3> K = product(PHt, V_inverse);
    const Vec<double, dim> x = product(K, e);
    const Mat<double, dim, dim> KHP = product_transposed(K, PHt);
    for (int c = 0; c < dim; ++c) {
      for (int r = 0; r <= c; ++r) P_(r, c) = P_(c, r) = 0.5 * ((P_(r, c) - KHP(r, c)) + (P_(c, r) - KHP(c, r)));
    }
    R_g_ = SO3<double>::exp(segment<3>(x, world)) * R_g_;
    bias_ += segment<3>(x, bias);
    phi_ += segment<3>(x, mount);
    d_ += x[clock];
  }

  /// The correction of the clock that is beyond doubt [s]; from now on it is in force.
  double take_time_offset() {
    const double sigma = time_offset_sigma();
    if (in_a_row_ < options_.min_in_a_row || !(sigma < options_.max_doubt_s)) return 0;
    const double least =
        clock_is_wrong_ ? options_.trust * sigma : std::max(options_.min_error_s, options_.doubt * sigma);
    if (!(std::abs(d_) > least)) return 0;
    clock_is_wrong_ = true;
    forget_mount();  // it was found with the clock wrong
    const double wanted = corrected_s_ + std::clamp(d_, -options_.max_step_s, options_.max_step_s);
    const double step = std::clamp(wanted, -options_.max_correction_s, options_.max_correction_s) - corrected_s_;
    corrected_s_ += step;
    d_ -= step;
    P_(clock, clock) += options_.step_error * options_.step_error * step * step;
    return step;
  }

 private:
  static constexpr int world = 0, bias = 3, mount = 6, clock = 9, dim = 10;

  void forget(int at, double sigma) {
    for (int k = at; k < at + 3; ++k) {
      for (int i = 0; i < dim; ++i) P_(k, i) = P_(i, k) = 0;
      P_(k, k) = sigma * sigma;
    }
  }
  /// The first orientation in a world: the two are brought together.
  void meet(const SO3<double>& R_v, const Vec3& w) {
    R_g_ = R_v * SO3<double>::exp(phi_ + d_ * w).inverse();
    forget(world, 1);
    has_world_ = true;
    left_out_ = 0;
  }
  void leave_out() {
    in_a_row_ = 0;
    if (++left_out_ <= options_.max_left_out) return;
    forget(bias, options_.bias_sigma);
    forget_world();
  }

  CameraImuOptions options_;
  Mat<double, dim, dim> P_ = zeros<double, dim, dim>();  ///< of [c b phi d]
  SO3<double> R_g_;
  Vec3 bias_ = zeros<Vec3>(), phi_ = zeros<Vec3>();
  double d_ = 0, corrected_s_ = 0;
  bool has_world_ = false, clock_is_wrong_ = false;
  int left_out_ = 0, in_a_row_ = 0;  ///< orientations that did not fit, and that did, in a row
};

}  // namespace plumbline
