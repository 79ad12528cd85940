#pragma once
/// How well pairs of bearings agree with a motion: rotation alone, of a plane, any.         docs/math/geometry.md 8
///
///   rho(x, T) = 5.991 - x  if x < T, else 0,   x squared errors in units of the noise s of one bearing
///   S_E = sum 2 rho(d/s^2, 3.841),  d of (20)                                                                  (27)
///   S_H = sum rho(d1/2s^2, 5.991) + rho(d2/2s^2, 5.991),  d1 of (23), d2 of H^-1;   S_R the same of H = R
///   support of a motion = sum of S_E over the pairs that it has in front of both views, less that of those behind (28)
///   noise: s^2 = mean of d below 9 s^2, repeated from three times the s that was said                         (29)
/// The noise of both bearings is in each of these errors.

#include <algorithm>
#include <cmath>
#include <span>

#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/epipolar.hpp"
#include "plumbline/geometry/essential_matrix.hpp"
#include "plumbline/geometry/homography.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// A motion and its support.
template <class S>
struct SupportedMotion {
  SE3<S> T_2_1;      ///< translation of length 1
  S support = S(0);  ///< (28)
  int pairs = 0;     ///< met within the gate of (27), and in front of both views
};

template <class S>
class TwoViewScores {
 public:
  using Pairs = std::span<const BearingPair<S>>;
  static constexpr S most = S(5.991), gate_plane = S(5.991), gate_epipolar = S(3.841);  // 95 % of two and of one dof

  TwoViewScores(Pairs pairs, S sigma) : pairs_(pairs), scale_(S(1) / (sigma * sigma)), slack_(3 * sigma) {}

  /// (27), or any smaller number once it cannot exceed `best` any more.
  S essential(const Mat<S, 3, 3>& E, S best = S(0)) const {
    return sum(best, [&](const BearingPair<S>& pair) { return epipolar_score(E, pair); });
  }
  S homography(const Mat<S, 3, 3>& H, S best = S(0)) const {
    const Mat<S, 3, 3> C = cofactor_matrix(H);
    Mat<S, 3, 3> inverse;  // times det H > 0
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) inverse(i, j) = C(j, i);
    }
    return sum(best, [&](const BearingPair<S>& pair) {
      return rho(scale_ / 2 * transfer_error(H, pair.f1, pair.f2), gate_plane) +
             rho(scale_ / 2 * transfer_error(inverse, pair.f2, pair.f1), gate_plane);
    });
  }

  /// (29)
  S noise(const Mat<S, 3, 3>& E, S at_most) const {
    S squared = at_most * at_most;
    for (int iteration = 0; iteration < 8; ++iteration) {
      S total = 0;
      int count = 0;
      for (const BearingPair<S>& pair : pairs_) {
        const S d = sampson_error(E, pair);
        if (!(d < 9 * squared)) continue;
        total += d;
        ++count;
      }
      if (count > 0) squared = std::min(squared, total / S(count));
    }
    return std::sqrt(squared);
  }

  /// (28). A pair is behind when it is by more than its noise.
  SupportedMotion<S> supported(const SE3<S>& T_2_1) const {
    SupportedMotion<S> out{T_2_1, S(0), 0};
    const Mat<S, 3, 3> R = T_2_1.R(), E = essential_matrix(T_2_1);
    const Vec<S, 3>& t = T_2_1.p();
    for (const BearingPair<S>& pair : pairs_) {
      const S score = epipolar_score(E, pair);
      if (!(score > S(0))) continue;
      const Vec<S, 3> a = product(R, pair.f1), across = pair.f2.cross(t);
      const S length = norm(across), angle = -dot(pair.f2.cross(a), across) / length;  // between f2 and R f1, signed
      const bool behind = angle < -slack_ || dot(pair.f2, a) * length + angle * dot(pair.f2, t) < S(0);
      out.support += behind ? -score : score;
      out.pairs += !behind;
    }
    return out;
  }

 private:
  static S rho(S x, S gate) { return x < gate ? most - x : S(0); }  // 0 for NaN
  S epipolar_score(const Mat<S, 3, 3>& E, const BearingPair<S>& pair) const {
    return 2 * rho(scale_ * sampson_error(E, pair), gate_epipolar);
  }
  template <class Score>
  S sum(S best, Score&& score_of) const {
    S total = 0, possible = S(pairs_.size()) * 2 * most;
    for (const BearingPair<S>& pair : pairs_) {
      const S score = score_of(pair);
      total += score;
      possible -= 2 * most - score;
      if (!(possible > best)) break;
    }
    return total;
  }

  Pairs pairs_;
  S scale_, slack_;
};

}  // namespace plumbline
