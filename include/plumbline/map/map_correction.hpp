#pragma once
/// How well a map knows where the present world is in it.                                          docs/math/map.md 1
///
///   P_k = A P_n A^T + Q_nk                                                                                    (7a)
/// is the covariance of the pose of keyframe k in the map: P_n that of keyframe n, which the last correction ended with
/// (of the pose graph, or of the localization in a saved map); A, Q_nk of the odometry from n to k. The origin is the
/// first keyframe of the map.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/map/loop_gate.hpp"

namespace plumbline {

template <class Places>
class MapCorrection {
 public:
  using Residual = typename Places::Residual;
  using Covariance = typename Places::Covariance;

  /// The correction has changed: it ends with keyframe `id`, whose pose in the map has the covariance P. `is_known`:
  /// false where it could not be computed.
  void set(std::uint32_t id, const Covariance& P, bool is_known) {
    id_ = id;
    P_ = P;
    is_known_ = is_known && all_finite(P);
  }
  /// Keyframe k is about to be removed.
  void before_removal(const Places& places, int k) {
    if (!is_known_ || places.keyframe(k).id != id_) return;
    is_known_ = k + 1 < places.size() && covariance(places, k + 1, P_);
    if (is_known_) id_ = places.keyframe(k + 1).id;
  }
  void forget() { is_known_ = false; }

  /// Covariance of the pose in the map of keyframe k, for increments of the residual: heading and position in the body
  /// [rad, m] with an IMU; [rad, m]; [rad, m, log scale] of a camera alone. False before the first correction, where it
  /// is not known, and where k lies before the keyframe that the last correction ended with.
  bool covariance(const Places& places, int k, Covariance& out) const {
    const int n = is_known_ ? places.find(id_) : Places::none;
    if (n == Places::none || k < n) return false;
    OdometryChain<Residual> chain(places.graph().pose(n));
    for (int j = n + 1; j <= k; ++j)
      chain.append(places.graph().odometry(j).residual.measured, places.graph().odometry(j).covariance());
    const Covariance A = Residual::transport(places.graph().pose(n), chain.pose());
    const Covariance P = product_transposed(product(A, P_), A) + chain.covariance();  // (7a)
    out = P;
    return all_finite(out);
  }

 private:
  std::uint32_t id_ = 0;
  bool is_known_ = false;
  Covariance P_ = zeros<Covariance>();
};

}  // namespace plumbline
