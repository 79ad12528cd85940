#pragma once
/// The pose of the present world in a map that is not changed: loops are measurements of a filter.     docs/math/map.md
/// 4
///
///   T_k = T_j T_jk,   P_k = A P_j A^T + Q_jk        along the odometry since the last loop                        (10)
///   K = P J^T (J P J^T + Q_loop)^-1,   T <- T [+] -K r,   P <- P - K J P    with r, J of the loop's residual at T
///   (11)
/// A loop whose chi-square the filter excludes is left out; after two of them the third restarts the filter.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/map/loop_gate.hpp"

namespace plumbline {

template <class Places>
class MapLocalizer {
 public:
  using Residual = typename Places::Residual;
  using S = typename Places::S;
  using Pose = typename Places::Pose;
  using Covariance = typename Places::Covariance;

  bool is_localized() const { return is_localized_; }
  /// T_map_body of the keyframe of the last loop.
  const Pose& pose() const { return T_; }
  const Covariance& covariance() const { return P_; }
  void reset() { is_localized_ = false; }

  /// Takes a verified loop. False where the filter excludes it.
  template <class Loop>
  bool add(const Places& places, const Loop& loop, const LoopGateOptions& gate) {
    const Pose T_measured = places.graph().pose(places.find(loop.i)) * loop.T_i_j;
    const int from = is_localized_ ? places.find(id_) : Places::none, to = places.find(loop.j);
    if (from == Places::none || from > to || excluded_ == 2) return begin(T_measured, loop);
    OdometryChain<Residual> chain(T_);  // (10)
    for (int k = from + 1; k <= to; ++k)
      chain.append(places.graph().odometry(k).residual.measured, places.graph().odometry(k).covariance());
    const Covariance A = Residual::transport(T_, chain.pose());
    const Covariance P = product_transposed(product(A, P_), A) + chain.covariance();
    const auto lin = Residual{loop.T_i_j}.linearize(places.graph().pose(places.find(loop.i)), chain.pose());
    if (!lin.valid) return false;
    const Covariance JP = product(lin.J_r_j, P);
    const Covariance innovation = Covariance(product_transposed(JP, lin.J_r_j)) + loop.covariance;
    const Result<Covariance> L = square_root_information(innovation);
    if (!L) return false;
    const double chi2 = double(squared_norm(Vec<S, Residual::dim>(times(*L, lin.r))));
    if (!(chi_square_survival(chi2, Residual::dim) >= gate.rejected_share)) {
      ++excluded_;
      return false;
    }
    const Covariance LJP = product(*L, JP);  // (11): K = (L J P)^T L
    Vec<S, Residual::dim> d = zeros<S, Residual::dim>();
    const Vec<S, Residual::dim> whitened = times(*L, lin.r);
    for (int a = 0; a < Residual::dim; ++a)
      for (int b = 0; b < Residual::dim; ++b) d[a] -= LJP(b, a) * whitened[b];
    T_ = Residual::moved(chain.pose(), d);
    P_ = P;
    for (int a = 0; a < Residual::dim; ++a)
      for (int b = 0; b < Residual::dim; ++b)
        for (int c = 0; c < Residual::dim; ++c) P_(a, b) -= LJP(c, a) * LJP(c, b);
    id_ = loop.j;
    excluded_ = 0;
    return true;
  }

 private:
  template <class Loop>
  bool begin(const Pose& T_measured, const Loop& loop) {
    T_ = T_measured;
    P_ = loop.covariance;
    id_ = loop.j;
    excluded_ = 0;
    is_localized_ = true;
    return true;
  }

  bool is_localized_ = false;
  int excluded_ = 0;
  std::uint32_t id_ = 0;
  Pose T_;
  Covariance P_ = zeros<Covariance>();
};

}  // namespace plumbline
