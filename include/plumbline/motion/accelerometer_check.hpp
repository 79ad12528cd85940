#pragma once
/// Whether an accelerometer tells of the motion that is seen.                           docs/math/inertial_window.md
///
/// Images, and the readings between two of them, give the velocity at the first; the readings carry it on:
///   s_k = (p_k+1 - p_k - q_k) / dt_k,     G_k = G_k-1 + s_k - s_k-1 - w_k-1                                   (1d)
///   q, w: way of a body that was at rest, and its gain of velocity, as the readings foretell them, gravity included
/// G is velocity that is seen to be gained, and not read. An accelerometer that is wrong is so all the while: G grows
/// in the first half of some time as in the second. Images that are wrong make it jump.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/ring_buffer.hpp"
#include "plumbline/imu/nav_state.hpp"

namespace plumbline {

struct AccelerometerCheckOptions {
  double half_s = 0.25;             ///< G is watched for twice as long
  double max_error = 0.6;           ///< of the acceleration: more, in both halves, is no bias [m/s^2],
  double sigmas = 3;                ///< nor the noise of the places
  double max_error_disputed = 0.3;  ///< the same where the window finds that images and readings disagree
  double sigmas_disputed = 1.5;
  double proven_s = 3;   ///< of motion that agreed: before, biases, tilt and mount may as well be wrong
  double settles_s = 3;  ///< since it was last wrong
};

template <class S>
class AccelerometerCheck {
 public:
  explicit AccelerometerCheck(const AccelerometerCheckOptions& options) : options_(options) {}

  /// The next frame of a body that moves: its place by its images with sigma [m], the frame before with its state, and
  /// what the readings make of that state in dt > 0. `disputed`: images and readings disagree in other ways.
  void update(const Vec<S, 3>& p, S sigma, const Vec<S, 3>& p_before, const NavState<S>& before,
              const NavState<S>& foretold, S dt, bool disputed) {
    const Vec<S, 3> q = foretold.T_world_body.p() - before.T_world_body.p() - dt * before.v_world_body;
    const Vec<S, 3> v = (p - p_before - q) / dt;
    if (!gains_.empty()) gained_ += v - carried_on_;  // (1d)
    carried_on_ = v + foretold.v_world_body - before.v_world_body;
    t_s_ += double(dt);
    gains_.push_back({t_s_, gained_});

    const double place_sigmas = disputed ? options_.sigmas_disputed : options_.sigmas;
    const double limit = disputed ? options_.max_error_disputed : options_.max_error;
    const double noise = 2 * double(sigma) / (double(dt) * options_.half_s);  // of the gain in one half
    const bool wrong = error() > std::max(limit, place_sigmas * noise);
    if (!wrong && !disputed) proven_s_ += double(dt);
    since_wrong_s_ = wrong && proven_s_ > options_.proven_s ? 0 : since_wrong_s_ + double(dt);
  }
  /// What comes is not next to what was.
  void interrupt() { gains_.clear(); }

  bool in_doubt() const { return since_wrong_s_ < options_.settles_s; }

 private:
  struct Gain {
    double t_s;
    Vec<S, 3> v;
  };

  /// Acceleration that both halves of the time watched agree on [m/s^2]; 0 before there is so much.
  double error() const {
    const std::size_t last = gains_.size() - 1, middle = half_before(last), first = half_before(middle);
    if (first == none) return 0;
    const auto acceleration = [&](std::size_t from, std::size_t to) -> Vec<S, 3> {
      return (gains_[to].v - gains_[from].v) / S(gains_[to].t_s - gains_[from].t_s);
    };
    const Vec<S, 3> early = acceleration(first, middle), late = acceleration(middle, last);
    return dot(early, late) > S(0) ? double(std::min(norm(early), norm(late))) : 0;
  }
  /// The latest of those that are older by half the time or more.
  std::size_t half_before(std::size_t k) const {
    if (k == none) return none;
    const double t_s = gains_[k].t_s - 0.99 * options_.half_s;
    while (k > 0 && gains_[k].t_s > t_s) --k;
    return gains_[k].t_s > t_s ? none : k;
  }
  static constexpr std::size_t none = std::numeric_limits<std::size_t>::max();

  AccelerometerCheckOptions options_;
  Vec<S, 3> gained_ = zeros<S, 3>(), carried_on_ = zeros<S, 3>();
  RingBuffer<Gain, 64> gains_;  ///< 128 Hz; of a faster camera nothing is said
  double t_s_ = 0, proven_s_ = 0, since_wrong_s_ = std::numeric_limits<double>::infinity();
};

}  // namespace plumbline
