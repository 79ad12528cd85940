#pragma once
/// Edges between neighboring keyframes: the odometry of the window, with its covariance.            docs/math/map.md 1
///
///   T_(k-1)k = T_(k-1)^-1 T_k, with the poses that both have when the first of them retires from the window        (5)
///   Q_k = (P_k - A P_(k-m) A^T)/m + F, what the window's covariance has grown by; negative eigenvalues are zero  (6a)
/// F is the noise floor of an edge. P is that of the newest frame of the window, with the noise of its own
/// observations, and grows less than this noise from keyframe to keyframe: (6a) is the mean growth over m keyframes. A
/// growth from one to the next of 25 times the variance that those before it had is that of a visual outage: it is kept
/// whole, m = 1, and the mean restarts. A keyframe of the window is as certain as a newer one moved to its place. A
/// keyframe of a new world has an edge without information. Where the window has told the covariance of an edge (6), as
/// the older keyframe retires, that is taken; until then the mean of those it has told before.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/symmetric_eigen.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

struct OdometryEdgeOptions {
  double sigma_rotation = 3e-4;   ///< floor of an edge [rad]; geometry: a tenth of a pixel at 450 px
  double sigma_position = 1e-3;   ///< floor of an edge [m]
  int mean_keyframes = 50;        ///< m of (6a) at most, and edges of the mean of (6)
  double unknown_rotation = 10;   ///< sigma of an edge to a new world [rad]
  double unknown_position = 1e3;  ///< [m]
};

/// Keyframe: place_keyframe.hpp.
template <class Keyframe>
class OdometryEdges {
 public:
  using S = typename Keyframe::Scalar;

  explicit OdometryEdges(const OdometryEdgeOptions& options) : options_(options) {}

  /// Measures the edge from keyframe k - 1 to k, (5), (6a). `at(k)` is the k-th keyframe.
  template <class At>
  void measure(At&& at, int k) const {
    Keyframe& keyframe = at(k);
    const Keyframe& before = at(k - 1);
    keyframe.T_before = before.T_world_body.inverse() * keyframe.T_world_body;
    const Mat<S, 6, 6> of_window = keyframe.Q;
    set_zero(keyframe.Q);
    keyframe.begins_mean = false;
    const bool is_connected = before.world == keyframe.world;
    if (is_connected) {
      const Keyframe& earlier = at(first_of_mean(at, k));
      const S m = S(k - first_of_mean(at, k));
      keyframe.Q = (S(1) / m) * growth(earlier, keyframe);
      const Mat<S, 6, 6> alone = growth(before, keyframe);
      keyframe.growth = position_variance(alone);
      keyframe.begins_mean = is_outage(at, k);
      if (keyframe.is_known) {
        keyframe.Q = of_window;
        return;
      }
      if (keyframe.begins_mean)
        keyframe.Q = alone;
      else if (take_mean_of_known(at, k))
        return;
    }
    const S rotation = S(is_connected ? options_.sigma_rotation : options_.unknown_rotation);
    const S position = S(is_connected ? options_.sigma_position : options_.unknown_position);
    for (int i = 0; i < 3; ++i) {
      keyframe.Q(i, i) += rotation * rotation;
      keyframe.Q(3 + i, 3 + i) += position * position;
    }
  }
  /// The uncertainty of a keyframe does not exceed that of a later one: the window is smoothed. The first keyframes of
  /// a camera alone are given theirs before it has ranges.
  template <class At>
  static void carry_back(At&& at, int newest_k) {
    const Keyframe& newest = at(newest_k);
    for (int k = newest_k - 1; k >= 0; --k) {
      Keyframe& earlier = at(k);
      if (earlier.is_retired || earlier.world != newest.world) return;
      const Mat<S, 6, 6> P = transported(newest.covariance, newest.T_world_body, earlier.T_world_body);
      if (position_variance(P) < position_variance(earlier.covariance)) earlier.covariance = P;
    }
  }

 private:
  /// The first keyframe of the mean (6a) that ends at k.
  template <class At>
  int first_of_mean(At&& at, int k) const {
    int first = k - 1;
    while (first > 0 && k - first < options_.mean_keyframes && at(first - 1).world == at(k).world &&
           !at(first).begins_mean)
      --first;
    return first;
  }
  /// Sets the covariance of edge k to the mean of those that the window has told of the edges before it, without
  /// outages. False where there is none.
  template <class At>
  bool take_mean_of_known(At&& at, int k) const {
    Mat<S, 6, 6> sum = zeros<S, 6, 6>();
    int n = 0;
    for (int before = k - 1; before > 0 && k - before <= options_.mean_keyframes; --before) {
      const Keyframe& known = at(before);
      if (known.world != at(k).world) break;
      if (!known.is_known || known.begins_mean) continue;
      sum += known.Q;
      ++n;
    }
    if (n > 0) at(k).Q = (S(1) / S(n)) * sum;
    return n > 0;
  }
  /// Whether keyframe k alone has grown more than noise explains.
  template <class At>
  bool is_outage(At&& at, int k) const {
    S sum = S(0);
    int n = 0;
    for (int before = k - 1; before > first_of_mean(at, k); --before, ++n) sum += at(before).growth;
    return n >= 3 && S(n) * at(k).growth > S(25) * sum;
  }
  static Mat<S, 6, 6> growth(const Keyframe& from, const Keyframe& to) {
    return positive_part(to.covariance - transported(from.covariance, from.T_world_body, to.T_world_body));
  }
  static S position_variance(const Mat<S, 6, 6>& P) { return P(3, 3) + P(4, 4) + P(5, 5); }
  /// The symmetric matrix without its negative eigenvalues.
  static Mat<S, 6, 6> positive_part(const Mat<S, 6, 6>& A) {
    const SymmetricEigen<S, 6> eigen(A);
    Mat<S, 6, 6> out = zeros<S, 6, 6>();
    for (int n = 0; n < 6; ++n) {
      if (!(eigen.values[n] > S(0))) continue;
      for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 6; ++j) out(i, j) += eigen.values[n] * eigen.V(i, n) * eigen.V(j, n);
    }
    return out;
  }

  OdometryEdgeOptions options_;
};

}  // namespace plumbline
