#pragma once
/// Feature kind: straight edges that hold points of another kind, known by these points alone.
///                                                                                        docs/math/collinear.md
/// A line in the camera of its anchor, as those of LineKind, measured by the segments of keyframes. What is on it are
/// landmarks of the points before it in the list of features; in the window they are tied to it,
///   1/2 rho(|r - [offset; 0]|^2 / sigma^2),   sigma^2 = tolerance^2 + offset^2,                              (3)
/// r of residual/collinear_point.hpp,
/// and by them, not by its looks, it is recognized in the next keyframe.
///
/// Between keyframes nobody looks for segments: the outermost of its points in sight stand for one (`from_points`).
/// They measure a frame against the line that the keyframes know; the window has them as points already.

#include <cmath>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

template <class S, bool rolls>
struct CollinearObservation : SegmentObservation<S, false, rolls, false> {
  bool from_points = false;  ///< the ends are points, no segment was looked for
};

template <SensorRig SensorsT, template <class> class Loss = Huber>
struct CollinearKind : LineKind<SensorsT, Loss, CollinearObservation<typename SensorsT::Scalar, SensorsT::rolls>> {
  using Lines = LineKind<SensorsT, Loss, CollinearObservation<typename SensorsT::Scalar, SensorsT::rolls>>;
  using Sensors = SensorsT;
  using S = typename Lines::S;
  using typename Lines::InAnchor;
  using typename Lines::Linearized;
  using typename Lines::Observation;
  static constexpr int max_points = 12;     ///< on one line
  static constexpr S tolerance = S(0.003);  ///< of (3), distance by range: edges are not perfectly straight
  static constexpr Loss<S> point_loss = Lines::pixel_loss;

  /// Whether landmarks of this kind may lie on the line.
  template <class K>
  static constexpr bool holds = K::dim == 1;

  struct Member {
    std::uint32_t id;
    float offset_px = 0;  ///< beside the segment, in the last keyframe that showed both
    S offset = S(0);      ///< the same in the first one [rad]: what is beside an edge need not have its depth
    int hint = 0;         ///< where in its store it was found last
    int misfits = 0;      ///< optimizations in a row that put it elsewhere

    S sigma() const { return std::hypot(tolerance, offset); }  ///< of (3)
  };
  struct Appearance {
    FixedVector<Member, max_points> points;
  };

  template <class Rows>
  static double add_view(const Sensors& rig, const Linearized& line, const Observation& seen,
                         const RelativeView<S>& view, int slot, Rows& rows) {
    return seen.from_points ? 0 : Lines::add_view(rig, line, seen, view, slot, rows);
  }
  static double cost(const Sensors& rig, const InAnchor& line, const Observation& seen, const RelativeView<S>& view) {
    return seen.from_points ? 0 : Lines::cost(rig, line, seen, view);
  }
  static void keep_fitting(const Sensors& rig, const InAnchor& line, Observation& seen, const RelativeView<S>& view) {
    if (!seen.from_points) Lines::keep_fitting(rig, line, seen, view);
  }
};

/// The store of the landmarks that a kind holds, among those before it.
template <class Kind, class First, class... Rest>
const auto& held_of(const First& first, const Rest&... rest) {
  if constexpr (Kind::template holds<typename First::Kind>) {
    return first;
  } else {
    static_assert(sizeof...(Rest) > 0, "plumbline: collinear features need points named before them");
    return held_of<Kind>(rest...);
  }
}

/// Where in its store a member is; -1 when it is gone.
template <class Store, class Member>
int index_of(const Store& store, Member& member) {
  const auto& landmarks = store.landmarks();
  const auto is_it = [&](std::size_t i) { return i < landmarks.size() && landmarks[i].id == member.id; };
  if (is_it(static_cast<std::size_t>(member.hint))) return member.hint;
  for (std::size_t i = 0; i < landmarks.size(); ++i) {
    if (is_it(i)) return member.hint = static_cast<int>(i);
  }
  return -1;
}

}  // namespace plumbline
