#pragma once
// A room of points with descriptors of their own, and keyframes that see them.

#include <cmath>
#include <vector>

#include "plumbline/core/random.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::test {

struct SimulatedPlaces {
  struct Point {
    Vec<double, 3> p;
    BinaryDescriptor descriptor;
  };
  std::vector<Point> points;
  testing::Gaussian noise;
  Random random;
  double sigma_rad = 0.002, relative_sigma_range = 0.01;
  int turned_bits = 8;  ///< of 256, from view to view

  explicit SimulatedPlaces(std::uint64_t seed) : noise(seed), random(seed) {}

  /// Points on the walls of a room of that half width around the origin.
  void furnish(int count, double half_width) {
    for (int n = 0; n < count; ++n) {
      const double u = uniform(-1, 1), v = uniform(-1, 1), side = random.below(2) ? 1 : -1;
      Vec<double, 3> p(u, side, v);
      if (random.below(2)) p = Vec<double, 3>(side, u, v);
      points.push_back({Vec<double, 3>(half_width * p), descriptor()});
    }
  }
  double uniform(double low, double high) { return low + (high - low) * random.uniform(); }
  BinaryDescriptor descriptor() {
    BinaryDescriptor out;
    for (auto& word : out.words) word = random.next();
    return out;
  }
  BinaryDescriptor seen(BinaryDescriptor d) {
    for (int n = 0; n < turned_bits; ++n) {
      const std::uint32_t bit = random.below(256);
      d.words[bit / 64] ^= std::uint64_t{1} << (bit % 64);
    }
    return d;
  }
  /// What a camera at that true pose sees, within 40 degrees of its axis; ranges in units of 1/scale m.
  template <class Features>
  void look(const SE3<double>& T_world_cam, Features& features, double scale = 1) {
    for (const Point& point : points) {
      const Vec<double, 3> p = T_world_cam.inverse() * point.p;
      const double range = norm(p);
      if (!(p.z() > 0.77 * range)) continue;
      PlaceFeature feature{seen(point.descriptor)};
      Vec<double, 3> bearing = p / range;
      for (int k = 0; k < 3; ++k) bearing[k] += sigma_rad * noise();
      feature.bearing = cast_to<float>(normalized(bearing));
      feature.sigma_rad = float(sigma_rad);
      feature.range = float(scale * range * (1 + relative_sigma_range * noise()));
      feature.sigma_range = float(relative_sigma_range * feature.range);
      features.push_back(feature);
    }
  }
};

/// A camera that looks along the direction of that heading, horizontally.
inline SE3<double> looking_along(double heading, const Vec<double, 3>& p) {
  Mat<double, 3, 3> R;
  R << std::sin(heading), 0, std::cos(heading), -std::cos(heading), 0, std::sin(heading), 0, -1, 0;
  return SE3<double>(SO3<double>::from_matrix(R), p);
}

}  // namespace plumbline::test
