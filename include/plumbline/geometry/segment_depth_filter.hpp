#pragma once
/// The inverse ranges of both ends of a segment from where other views see its line: a depth filter for each, on the
/// ray of the end in the anchor.                                                            docs/math/direct.md
///
///   m . P(lambda) = 0,  P = R b + lambda t   =>   lambda = -(m . R b)/(m . t),   m the plane of the other view (17)
///   tau^2 = w^T C w |P|^2/(m . t)^2,   P/|P| = w_s b_s + w_e b_e,   C of the angles of both ends across      (18)
///   b + delta m_a instead of b:   lambda + h delta,   h = -(m . R m_a)/(m . t)                                (19)
///   beta' = beta + K (h - beta),  K of the filter;   Sigma = sigma^2 + beta^2 var(delta)                      (20)
/// delta, the angle across the edge by which the anchor's own ray is wrong, is the same in all measurements. They do
/// not average it out: the filter keeps how far it moved the mean, beta, beside its own sigma.

#include <array>
#include <cmath>

#include <Eigen/Geometry>

#include "plumbline/core/matrix.hpp"
#include "plumbline/geometry/depth_filter.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// The rays through both ends of a segment in one camera.
template <class S>
struct SegmentRays {
  Vec<S, 3> start, end;  ///< unit
  Mat<S, 2, 2> C;        ///< of their angles across the segment [rad^2]
};

template <class S>
class SegmentDepthFilter {
 public:
  struct End {
    DepthFilter<S> depth;  ///< of the inverse range [1/m]
    S by_anchor = S(0);    ///< beta of (20) [1/m/rad]
  };

  static SegmentDepthFilter around(S mu) {
    SegmentDepthFilter out;
    for (End& end : out.ends_) end.depth = DepthFilter<S>::around(mu);
    return out;
  }
  bool known() const { return ends_[0].depth.known(); }
  const std::array<End, 2>& ends() const { return ends_; }

  /// Fuses the depths of both ends of the anchor's segment from another view of the line; not where its plane (nearly)
  /// contains the baseline. The ends of the two segments need not be the same points.
  void update(const SegmentRays<S>& anchor, const SegmentRays<S>& seen, const SE3<S>& T_seen_anchor) {
    constexpr S min_sine = S(0.17);  // 10 degrees between the edge and the way of the point in the image
    const Vec<S, 3> normal = seen.start.cross(seen.end), m_a = normalized(anchor.start.cross(anchor.end));
    const S sine = norm(normal);
    const Vec<S, 3> m = normal / sine;
    const Vec<S, 3>& t = T_seen_anchor.p();
    const S m_t = dot(m, t), h = -dot(m, T_seen_anchor.rotation() * m_a) / m_t;  // (19)
    for (int i = 0; i < 2; ++i) {
      End& end = ends_[std::size_t(i)];
      const Vec<S, 3> Rb = T_seen_anchor.rotation() * (i == 0 ? anchor.start : anchor.end);
      const S x = -dot(m, Rb) / m_t;  // (17)
      const Vec<S, 3> P = Rb + x * t;
      const S range = norm(P);
      const Vec<S, 3> d = P / range;
      if (!(std::abs(m_t) > min_sine * norm(t - dot(d, t) * d))) continue;  // NaN too
      const Vec<S, 2> w(dot(d.cross(seen.end), m) / sine, dot(seen.start.cross(d), m) / sine);
      const S tau2 = dot(w, seen.C * w) * (range * range) / (m_t * m_t);  // (18)
      const S h_beta = h - end.by_anchor, noise = tau2 + h_beta * h_beta * anchor.C(i, i);
      if (!(noise > S(0)) || !(noise < 4 * end.depth.variance)) continue;
      if (!(dot(d, seen.start + seen.end) > S(0))) {
        end.depth.miss();
      } else {
        end.by_anchor += end.depth.update(x, std::sqrt(noise)) * h_beta;  // (20)
      }
    }
  }

  /// Of the inverse range of one end, the error of the anchor's ray included [1/m^2].
  S variance(int i, const SegmentRays<S>& anchor) const {
    const End& end = ends_[std::size_t(i)];
    return end.depth.variance + end.by_anchor * end.by_anchor * anchor.C(i, i);
  }
  /// Both ends are known to `relative`, and most measurements meant them.
  bool converged(S relative, const SegmentRays<S>& anchor) const {
    for (int i = 0; i < 2; ++i) {
      const DepthFilter<S>& depth = ends_[std::size_t(i)].depth;
      if (!depth.converged(relative) || !(std::sqrt(variance(i, anchor)) < relative * depth.mu)) return false;
    }
    return true;
  }
  bool diverged() const { return ends_[0].depth.diverged() || ends_[1].depth.diverged(); }

 private:
  std::array<End, 2> ends_;
};

}  // namespace plumbline
