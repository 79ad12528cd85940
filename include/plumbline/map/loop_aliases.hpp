#pragma once
/// Displacements at which the surroundings look alike: doors of a corridor, tiles of a facade.    docs/math/map.md 3
///
///   a = t(T_i T_ij) - t(T_j)   of a verified pose that the odometry has excluded
///   (8)
///   chi^2(T_ij shifted by +-a) >= chi^2(T_ij) + 2 ln(odds)   for each a, else the odometry cannot tell them apart  (9)

#include <array>
#include <cmath>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/loop_gate.hpp"

namespace plumbline {

template <class S>
class LoopAliases {
 public:
  static constexpr int capacity = 16;

  /// A displacement (8), in the map. One that is known within a tenth counts once; the oldest one leaves.
  void add(const Vec<S, 3>& a) {
    if (!all_finite(a)) return;
    for (int k = 0; k < size_; ++k) {
      const Vec<S, 3>& known = displacements_[std::size_t(k)];
      const S limit = squared_norm(a) / S(100);
      if (squared_norm(known - a) < limit || squared_norm(known + a) < limit) return;
    }
    displacements_[std::size_t(next_)] = a;
    next_ = (next_ + 1) % capacity;
    if (size_ < capacity) ++size_;
  }
  void clear() { size_ = next_ = 0; }
  int size() const { return size_; }

  /// Whether the loop T_i_j is one of several that the odometry would accept (9).
  template <class Prediction>
  bool confuse(const Prediction& predicted, const typename Prediction::Pose& T_i_j, double odds) const {
    const double limit = predicted.chi2(T_i_j) + 2 * std::log(odds);
    for (int k = 0; k < size_; ++k) {
      for (const S sign : {S(1), S(-1)}) {
        if (predicted.chi2(shifted(predicted.T_i, T_i_j, sign * displacements_[std::size_t(k)])) < limit) return true;
      }
    }
    return false;
  }
  /// T_i_j, where node j is moved by `a` in the map.
  template <class Pose>
  static Pose shifted(const Pose& T_i, const Pose& T_i_j, const Vec<S, 3>& a) {
    if constexpr (requires { T_i.scale(); }) {
      return T_i.inverse() * Pose(S(1), SO3<S>(), a) * T_i * T_i_j;
    } else {
      return T_i.inverse() * Pose(SO3<S>(), a) * T_i * T_i_j;
    }
  }

 private:
  int size_ = 0, next_ = 0;
  std::array<Vec<S, 3>, capacity> displacements_;
};

}  // namespace plumbline
