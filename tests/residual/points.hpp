#pragma once
// Random scenes for the point residuals: two bodies with a camera each, and a point in front of both.

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/plus.hpp"

namespace plumbline::test {

inline Vec<double, 3> random_vector(Random& random, double size) {
  return size * Vec<double, 3>{2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
}

inline SE3<double> random_pose(Random& random, double angle, double distance) {
  const Vec<double, 3> phi = random_vector(random, angle);
  return SE3<double>(SO3<double>::exp(phi), random_vector(random, distance));
}

struct PointScene {
  Pinhole<double> camera{458, 457, 367, 248, {}};
  SE3<double> T_body_cam, T_world_anchor, T_world_target;
  Vec<double, 3> bearing;
  double lambda;  ///< 1/range [1/m]; every fourth scene is at or near infinity

  explicit PointScene(std::uint64_t seed) {
    Random random(seed);
    T_body_cam = random_pose(random, 2, 0.1);
    T_world_anchor = random_pose(random, 2, 3);
    T_world_target = T_world_anchor * random_pose(random, 0.2, 0.4);
    bearing = Vec<double, 3>{random.uniform() - 0.5, random.uniform() - 0.5, 1}.normalized();
    const double infinitely_far[] = {0, 1e-4};
    lambda = seed % 4 == 0 ? infinitely_far[(seed / 4) % 2] : 0.1 + random.uniform();
  }
};

}  // namespace plumbline::test
