#pragma once
/// Gates of a pose by images about the pose that the IMU predicts.                docs/math/inertial_window.md (1b)

#include <cmath>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/increment.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/propagation/inertial_options.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/propagation/velocity_uncertainty.hpp"
#include "plumbline/state/pose_prior.hpp"

namespace plumbline {

template <class S>
class PoseGates {
 public:
  /// Sets the sigmas of a predicted pose: those of the increment, a constant one for the rotation, and for the position
  /// one that grows with outage_s, the time since the last usable image [s].
  void predict(const ImuIncrement<S>& increment, const VelocityUncertainty<S>& velocity, S outage_s,
               const InertialOptions& options, PosePrior<S>& prior) {
    is_velocity_known_ = velocity.is_known();
    for (int k = 0; k < 3; ++k) {
      const auto sigma = [&](int i) { return std::sqrt(double(increment.covariance(i, i))); };
      prior.sigma[k] = S(elementary::hypot(options.rotation_sigma, sigma(k)));
      prior.sigma[3 + k] = S(elementary::hypot(options.velocity_sigma * double(outage_s), sigma(3 + k)));
      position_sigma_[k] = S(elementary::hypot(velocity.sigma() * double(outage_s), sigma(3 + k)));
    }
  }

  /// Innovation gate: whether T is within `gate` sigmas of the prediction.
  template <class State>
  static bool passes_innovation(const Prediction<State, S>& predicted, const SE3<S>& T, double gate) {
    return predicted.prior.passes_gate(minus(T, predicted.state.T_world_body), S(gate));
  }
  /// Consensus gate: the same with the velocity of the window. Always true where the window does not determine it.
  template <class State>
  bool passes_consensus(const Prediction<State, S>& predicted, const SE3<S>& T, double gate) const {
    if (!is_velocity_known_) return true;
    PosePrior<S> prior = predicted.prior;
    set_segment(prior.sigma, 3, position_sigma_);
    return prior.passes_gate(minus(T, predicted.state.T_world_body), S(gate));
  }

 private:
  Vec<S, 3> position_sigma_ = zeros<S, 3>();  ///< of the predicted frame, by the velocity of the window [m]
  bool is_velocity_known_ = false;
};

}  // namespace plumbline
