#pragma once
// A pose graph of keyframes that move straight on along x, in one or more worlds.

#include <memory>

#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_pose.hpp"

namespace plumbline::test {

inline Mat<double, 6, 6> isotropic(double sigma) { return sigma * sigma * identity<double, 6>(); }
inline SE3<double> along_x(double x) { return SE3<double>({}, {x, 0, 0}); }

struct StraightPlaces {
  using Places = PlaceGraph<RelativePoseResidual<double>, 12, 4, 3>;
  std::unique_ptr<Places> places = std::make_unique<Places>(PlaceGraphOptions{});
  std::uint32_t id = 0;

  /// Retired keyframes at x = begin, begin + 1, ... of the present world, with the next ids, from 1 on.
  void drive(int count, double begin = 0) {
    for (int k = 0; k < count; ++k) {
      const SE3<double> T = along_x(begin + k);
      ++id;
      if (!places->add(id, TimeNs(id), T, {}, isotropic(0.01 * id))) throw "a keyframe that should fit";
      places->retire(id, T);
    }
  }
};

}  // namespace plumbline::test
