#pragma once
/// The window of an estimator after vision and IMU were aligned: scaled, upright, with IMU factors, and solved.
///                                                                               docs/math/inertial_window.md

#include <algorithm>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline {

/// Gives the initializer the poses of the window, which have been solved since they were added.
void correct_poses(auto& initializer, const auto& frames, const auto& T_body_cam) {
  for (int slot = 0; slot < frames.slots; ++slot) {
    if (frames[slot].used) initializer.correct(frames[slot].t_ns, frames.T_world_body(slot) * T_body_cam);
  }
}

/// Restarts the window at the states of the alignment, `state_of(slot)`, and solves it; then once more, linearized at
/// the solution: the states of the alignment are too inaccurate for that. IMU factors are active from now on, the prior
/// is that of the alignment. Without depth the distance between the oldest and the newest frame is held by the sigma of
/// the scale: few frames alone determine it badly. That sigma is at least min_scale_sigma of the length, since the
/// errors of the aligned poses are correlated.
template <class Initializer>
void solve_aligned_window(const Initializer& initializer, const LevenbergMarquardtOptions& solver, const auto& view,
                          auto& window, const auto& propagation, const auto& T_body_cam, auto&& state_of) {
  auto& frames = window.frames();
  const auto restart = [&](auto&& states) {
    window.backend().restart(states, initializer.prior_on_biases(), T_body_cam,
                             propagation.time_offset(initializer.options().max_time_sigma_s));
  };
  const auto solve = [&](double length) {
    if constexpr (Initializer::needs_second_view) {
      const auto& options = initializer.options();
      const double noise = options.alignment.position_sigma * double(initializer.scale());
      const double sigma =
          elementary::hypot(std::max(initializer.scale_sigma(), options.min_scale_sigma) * length, noise);
      if (frames.size() > 1) window.backend().hold_distance(frames.oldest(), frames.newest(), length, sigma);
    }
    window.backend().optimize(view.rig, T_body_cam, window.landmarks(), solver);
  };
  window.landmarks().for_each([&](auto& store) { store.rescale(initializer.scale()); });
  restart(state_of);
  const double length =
      double(norm(frames.T_world_body(frames.newest()).p() - frames.T_world_body(frames.oldest()).p()));
  solve(length);
  restart([&](int slot) { return frames[slot].state.value(); });
  solve(length);
}

}  // namespace plumbline
