#pragma once
// Random scenes for the line residuals: two bodies with a camera each, and a segment in front of both.

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/geometry/line3.hpp"
#include "plumbline/residual/line_observation.hpp"
#include "residual/points.hpp"

namespace plumbline::test {

struct LineScene {
  enum Kind { ordinary, near_center, along_view };

  Pinhole<double> camera{458, 457, 367, 248, {}};
  SE3<double> T_body_cam, T_world_anchor, T_world_target;
  Vec<double, 3> p, q;              ///< endpoints in the anchor camera
  Line3<double> line;               ///< in the anchor camera
  LineReprojection<double> pixels;  ///< what the target measures, some pixels off
  LineInverseDepth<double> depth;   ///< the same

  explicit LineScene(std::uint64_t seed, Kind kind = ordinary) {
    Random random(seed);
    T_body_cam = random_pose(random, 2, 0.1);
    T_world_anchor = random_pose(random, 2, 3);
    T_world_target = T_world_anchor * random_pose(random, 0.2, 0.4);
    const SE3<double> T_target_anchor = (T_world_target * T_body_cam).inverse() * (T_world_anchor * T_body_cam);
    Vec<double, 3> p_t, q_t;  // in the target camera
    if (kind == near_center) {
      p_t << 0.05 + 0.05 * random.uniform(), 0.05 * random.uniform(), 0.1;
      q_t = p_t + Vec<double, 3>(0.02 * random.uniform(), 0.3, 0.2);
    } else if (kind == along_view) {
      p_t = random_vector(random, 0.4) + Vec<double, 3>(0.2, 0.6, 1.2);
      q_t = p_t + Vec<double, 3>{0.02 * random.uniform(), 0.02 * random.uniform(), 8};
    } else {
      p_t = random_vector(random, 1) + Vec<double, 3>(0, 0, 2.5);
      q_t = random_vector(random, 1) + Vec<double, 3>(0, 0, 3);
    }
    p = T_target_anchor.inverse() * p_t;
    q = T_target_anchor.inverse() * q_t;
    line = Line3<double>::through(p, q);
    const auto measured = [&](const Vec<double, 3>& X) -> Vec<double, 3> {
      const Vec<double, 3> off = random_vector(random, 0.005);
      return X / X.z() + Vec<double, 3>(off.x(), off.y(), 0);
    };
    depth.m_start = measured(p_t);
    depth.m_end = measured(q_t);
    depth.inverse_depth_measured << 1 / p_t.z() + 0.02, 1 / q_t.z() - 0.01;
    pixels.bearing_start = depth.m_start.normalized();
    pixels.bearing_end = depth.m_end.normalized();
    pixels.px_per_rad << 457, 470;
  }
};

template <class S>
LineReprojection<S> cast(const LineReprojection<double>& x) {
  return {x.bearing_start.cast<S>(), x.bearing_end.cast<S>(), x.px_per_rad.cast<S>()};
}
template <class S>
LineInverseDepth<S> cast(const LineInverseDepth<double>& x) {
  return {x.m_start.cast<S>(), x.m_end.cast<S>(), x.inverse_depth_measured.cast<S>()};
}

}  // namespace plumbline::test
