#pragma once
/// The pose of a single frame, as a map tells it, and the concept of a map that does.            docs/math/map.md 6

#include <concepts>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

template <class S>
struct FoundFrame {
  SE3<S> T_world_body;                         ///< S_map_world takes it to where the map has the body
  Mat<S, 6, 6> covariance = zeros<S, 6, 6>();  ///< of its right increment, with respect to the map [rad, m]
  int inliers = 0;                             ///< features that support it
};

/// find_frame(view, R_cur_prev, found): true where the map knows the place of a frame that the window has no pose for.
/// To be asked for each such frame, and for no other; `R_cur_prev` is the rotation that is expected of the camera since
/// the previous image of the view.
template <class M, class View>
concept FindsFrames = requires(M& map, const View& view, const SO3<typename View::S>& R_cur_prev,
                               FoundFrame<typename View::S>& found) {
  { map.find_frame(view, R_cur_prev, found) } -> std::same_as<bool>;
};

}  // namespace plumbline
