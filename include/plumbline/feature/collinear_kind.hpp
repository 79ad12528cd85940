#pragma once
/// Feature kind: straight edges through points of another kind, their members; recognized by these points.
///                                                                                        docs/math/collinear.md
/// The geometry is that of LineKind, a line in the camera of its anchor, measured by the segments of keyframes. Members
/// are landmarks of a kind of points that precedes it in the list of features. In the window every member adds
///   1/2 rho(|r - [offset; 0]|^2 / sigma^2),   sigma^2 = tolerance^2 + offset^2,                              (3)
/// r of residual/collinear_point.hpp. A line is recognized in the next keyframe by its members, not by its appearance.
///
/// Between keyframes no segments are detected: the outermost members in view give a substitute (`from_points`). It
/// measures the pose of a frame against the line; in the window it has no rows, since its points have theirs.

#include <cstdint>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/feature/segment_observation.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/robust_loss.hpp"

namespace plumbline {

/// Segment of a line in one frame.
template <class S, bool rolls>
struct CollinearObservation : SegmentObservation<S, false, rolls, false> {
  bool from_points = false;  ///< the ends are members; no segment was detected
};

template <SensorRig SensorsT, template <class> class Loss = Huber>
struct CollinearKind : LineKind<SensorsT, Loss, CollinearObservation<typename SensorsT::Scalar, SensorsT::rolls>> {
  using Lines = LineKind<SensorsT, Loss, CollinearObservation<typename SensorsT::Scalar, SensorsT::rolls>>;
  using Sensors = SensorsT;
  using S = typename Lines::S;
  using typename Lines::InAnchor;
  using typename Lines::Linearized;
  using typename Lines::Observation;
  static constexpr int max_points = 12;  ///< largest number of members of one line; tuned: docs/decisions/136 (chosen)
  /// Of (3), distance divided by range [rad], since edges are not perfectly straight;
  /// tuned: docs/decisions/136 (chosen).
  static constexpr S tolerance = S(0.003);
  static constexpr Loss<S> point_loss = Lines::pixel_loss;

  /// Whether landmarks of kind K can be members.
  template <class K>
  static constexpr bool can_contain = K::dim == 1;

  /// A point on the line.
  struct Member {
    std::uint32_t id;     ///< of the landmark
    float offset_px = 0;  ///< distance to the segment in the last keyframe that observed both [px]
    /// Distance to the segment in the first such keyframe [rad]; a point beside an edge may have another depth.
    S offset = S(0);
    int hint = 0;     ///< last known index in its store
    int misfits = 0;  ///< optimizations in a row after which it did not fit the line

    S sigma() const { return elementary::hypot(tolerance, offset); }  ///< sigma of (3) [rad]
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
  static void reject_outliers(const Sensors& rig, const InAnchor& line, Observation& seen,
                              const RelativeView<S>& view) {
    if (!seen.from_points) Lines::reject_outliers(rig, line, seen, view);
  }
};

/// The store of a kind's members among the stores before it.
template <class Kind, class First, class... Rest>
const auto& member_store_of(const First& first, const Rest&... rest) {
  if constexpr (Kind::template can_contain<typename First::Kind>) {
    return first;
  } else {
    static_assert(sizeof...(Rest) > 0, "plumbline: collinear features need points named before them");
    return member_store_of<Kind>(rest...);
  }
}

/// Index of a member in its store; -1 when the landmark was removed.
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
