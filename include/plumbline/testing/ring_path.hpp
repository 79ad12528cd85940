#pragma once
/// The center line of the ring corridor (testing/loop_scenes.hpp): a rectangle with round corners, counterclockwise.
///
/// With q the distance [m] along the rectangle from the middle of its south side, corners at q_k, unit directions d_k
/// before and d_(k+1) behind corner k, and the ramp and step of testing/jet.hpp:
///   p(q) = p(0) + q d_0 + sum_k (d_(k+1) - d_k) ramp(q - q_k + c/2, c)                                           (1)
///   heading(q) = pi/2 sum_k step(q - q_k + h/2, h)                                                               (2)
/// p is on the rectangle except within c/2 of a corner; |dp/dq| is 1 there, sqrt(1/2) in the middle of a corner.

#include <array>
#include <cmath>
#include <numbers>

#include "plumbline/core/matrix.hpp"
#include "plumbline/testing/jet.hpp"

namespace plumbline::testing {

struct RingPath {
  static constexpr double length = 15, width = 10;         ///< [m] along x and y
  static constexpr double lap = 2 * (length + width);      ///< [m]
  static constexpr double corner = 5, heading_change = 6;  ///< [m] c and h: where position and heading turn

  Jet x, y;
  Jet heading;  ///< [rad]; continuous, 2 pi more after each lap

  static RingPath at(const Jet& distance) {
    const double laps = std::floor(distance.value / lap);
    const Jet q = distance + (-laps * lap);
    RingPath out{q, {-width / 2, 0, 0}, {2 * std::numbers::pi * laps, 0, 0}};
    const std::array<Vec<double, 2>, 5> d = {Vec<double, 2>(1, 0), Vec<double, 2>(0, 1), Vec<double, 2>(-1, 0),
                                             Vec<double, 2>(0, -1), Vec<double, 2>(1, 0)};
    double q_k = length / 2;
    for (std::size_t k = 0; k < 4; ++k) {
      const Vec<double, 2> bend = d[k + 1] - d[k];
      const Jet r = chain(ramp(q.value - q_k + corner / 2, corner), q);
      out.x = out.x + bend.x() * r;
      out.y = out.y + bend.y() * r;
      out.heading =
          out.heading + (std::numbers::pi / 2) * chain(step(q.value - q_k + heading_change / 2, heading_change), q);
      q_k += k % 2 == 0 ? width : length;
    }
    return out;
  }
};

}  // namespace plumbline::testing
