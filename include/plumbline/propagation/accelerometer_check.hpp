#pragma once
/// Detector of accelerometer errors other than bias, such as a rotated or clipped axis, by comparison with images.
///                                                                                docs/math/inertial_window.md
///
/// The velocity s_k at frame k by images and IMU, and the gain of velocity G_k that images show and the accelerometer
/// does not measure:
///   s_k = (p_k+1 - p_k - q_k) / dt_k,     G_k = G_k-1 + s_k - s_k-1 - w_k-1                                   (1d)
///   p      position of a frame by its images [m]
///   q, w   displacement of a body at rest [m] and gain of velocity [m/s] by the IMU, gravity included
/// A wrong accelerometer makes G grow steadily, wrong images make it jump. So the slope of G is compared in two
/// successive intervals of half_s: an error is detected when both have the same direction and the smaller one exceeds
///   max(max_error, sigmas * 2 sigma_p / (dt half_s))   [m/s^2]

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/ring_buffer.hpp"
#include "plumbline/imu/nav_state.hpp"

namespace plumbline {

struct AccelerometerCheckOptions {
  double half_s = 0.25;  ///< duration of each of the two intervals [s]; tuned: docs/decisions/015
  /// Smallest acceleration error that is detected; less may be bias [m/s^2]; tuned: docs/decisions/015.
  double max_error = 0.6;
  double sigmas = 3;  ///< smallest error in sigmas of the positions; tuned: docs/decisions/015
  /// max_error while the window reports `IMU disagrees` [m/s^2]; tuned: docs/decisions/015.
  double max_error_inconsistent = 0.3;
  double sigmas_inconsistent = 1.5;  ///< sigmas while the window reports `IMU disagrees`; tuned: docs/decisions/015
  /// Consistent motion before the first detection [s]. Until then biases, tilt or extrinsics may be the cause;
  /// tuned: docs/decisions/015.
  double min_consistent_s = 3;
  /// Time for which the accelerometer stays suspect after the last detection [s]; tuned: docs/decisions/015.
  double hold_s = 3;
};

template <class S>
class AccelerometerCheck {
 public:
  explicit AccelerometerCheck(const AccelerometerCheckOptions& options) : options_(options) {}

  /// Adds the next frame of a moving body: position p by its images, with sigma [m], dt > 0 after the previous frame at
  /// p_before in state `before`, from which the IMU predicts predicted_state. `inconsistent`: the window reports that
  /// images and IMU disagree.
  void update(const Vec<S, 3>& p, S sigma, const Vec<S, 3>& p_before, const NavState<S>& before,
              const NavState<S>& predicted_state, S dt, bool inconsistent) {
    const Vec<S, 3> q = predicted_state.T_world_body.p() - before.T_world_body.p() - dt * before.v_world_body;
    const Vec<S, 3> v = (p - p_before - q) / dt;
    if (!gains_.empty()) gain_ += v - predicted_velocity_;  // (1d)
    predicted_velocity_ = v + predicted_state.v_world_body - before.v_world_body;
    t_s_ += double(dt);
    gains_.push_back({t_s_, gain_});

    const double position_sigmas = inconsistent ? options_.sigmas_inconsistent : options_.sigmas;
    const double limit = inconsistent ? options_.max_error_inconsistent : options_.max_error;
    const double noise = 2 * double(sigma) / (double(dt) * options_.half_s);  // of the slope of G
    const bool exceeded = error() > std::max(limit, position_sigmas * noise);
    if (!exceeded && !inconsistent) consistent_s_ += double(dt);
    since_detection_s_ = exceeded && consistent_s_ > options_.min_consistent_s ? 0 : since_detection_s_ + double(dt);
  }
  /// Restarts (1d): the next frame does not follow the last one.
  void interrupt() { gains_.clear(); }

  bool is_suspect() const { return since_detection_s_ < options_.hold_s; }

 private:
  struct Gain {
    double t_s;
    Vec<S, 3> v;
  };

  /// Acceleration error common to both intervals [m/s^2]; 0 before there are two.
  double error() const {
    const std::size_t last = gains_.size() - 1, middle = half_before(last), first = half_before(middle);
    if (first == none) return 0;
    const auto acceleration = [&](std::size_t from, std::size_t to) -> Vec<S, 3> {
      return (gains_[to].v - gains_[from].v) / S(gains_[to].t_s - gains_[from].t_s);
    };
    const Vec<S, 3> early = acceleration(first, middle), late = acceleration(middle, last);
    return dot(early, late) > S(0) ? double(std::min(norm(early), norm(late))) : 0;
  }
  /// Index of the latest entry that is half_s or more before entry k; none if there is no such entry.
  std::size_t half_before(std::size_t k) const {
    if (k == none) return none;
    const double t_s = gains_[k].t_s - min_part * options_.half_s;
    while (k > 0 && gains_[k].t_s > t_s) --k;
    return gains_[k].t_s > t_s ? none : k;
  }
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();
  /// Part of half_s that suffices; numerics: time stamps are rounded.
  static constexpr double min_part = 0.99;

  AccelerometerCheckOptions options_;
  Vec<S, 3> gain_ = zeros<S, 3>(), predicted_velocity_ = zeros<S, 3>();
  RingBuffer<Gain, 64> gains_;  ///< numerics: enough for 128 Hz; at higher rates nothing is detected
  double t_s_ = 0, consistent_s_ = 0, since_detection_s_ = std::numeric_limits<double>::infinity();
};

}  // namespace plumbline
