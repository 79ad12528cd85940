#pragma once
/// Lines through points, by the segments of keyframes.                                    docs/math/collinear.md
///
/// In a keyframe segments are detected, and the points that lie on one become its members. A segment that shares two
/// of them with a line that is known, far enough apart, is that line, if its place in space agrees; nothing of its
/// looks is kept but which side is bright. Lines that one segment belongs to are one. Between keyframes the outermost
/// members in sight stand for the line.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/collinear_kind.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/collinear_location.hpp"
#include "plumbline/frontend/points_on_segments.hpp"
#include "plumbline/frontend/segment_measurement.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_tracking.hpp"

namespace plumbline {

struct CollinearOptions {
  int target_count = 60;      ///< lines in sight
  float sigma_px = 0.4f;      ///< of an endpoint across the segment, however long and sharp the edge
  float peak_spacing_px = 4;  ///< of peaks along the edge that err independently
  float member_px = 4;        ///< a point this near to a segment is on it: corners are found beside their edges
  float separation_px = 10;   ///< of the two points that two views of a line must share, in both
  float same_line_px = 2;     ///< between a segment and where a line is seen that it belongs to
  double sigma_points = 3;    ///< of members that stand for their line, by their own: they count as points, too
  LineDetectorOptions detector;
  LineTrackingOptions tracking;  ///< of the edge that a detected segment is measured by
};

template <class Store, LineDetector Detector = LineSegmentDetector<>>
class CollinearSegments {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::S;
  using Landmark = typename Store::Landmark;
  using Observation = typename Kind::Observation;
  using Members = decltype(Kind::Appearance::points);
  using Options = CollinearOptions;
  static constexpr bool votes = false;
  static constexpr bool reads_kinds_before = true;

  explicit CollinearSegments(const Options& options) : options_(options) {}

  void follow(const View<Sensors>& view, const auto& /*window*/, Store& store, const SE3<S>& /*T_world_predicted*/,
              const auto& before) {
    const auto& points = points_of(before);
    for (Landmark& landmark : store.landmarks()) {
      forget_members(landmark, points);
      see_members(view, landmark, points);
      if (!landmark.current.valid) ++landmark.misses;
    }
  }

  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body,
              const auto& before) {
    const auto& points = points_of(before);
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    for (Landmark& landmark : store.landmarks()) {
      see_members(view, landmark, points);
      if (!landmark.current.valid || !landmark.located) continue;
      const LineReprojection<S>& seen = landmark.current.pixels.measured;
      landmark.geometry.set_extent(T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam),
                                   seen.bearing_start, seen.bearing_end);
    }
  }

  void locate(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& /*T_world_body*/,
              const auto& before) {
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.located && landmark.current.valid)
        locate_collinear(view.T_body_cam, window, landmark, points_of(before));
    }
  }

  void detect(const View<Sensors>& view, const auto& window, Store& store, int slot, const auto& before) {
    const auto& points = points_of(before);
    const ImageView<const std::uint8_t>& image = view.current.level(0);
    if (!edges_.compute(image, options_.detector.min_gradient)) return;
    detector_.detect(image, edges_, options_.detector, detected_);
    if (!edges_.compute(image, options_.detector.min_gradient)) return;  // the detector may have taken their pixels
    on_segments_.associate(points, detected_, options_.member_px);
    for (std::size_t k = 0; k < detected_.size(); ++k) {
      Members members = on_segments_.of(k, points);
      if (!are_apart(members, points, nullptr)) continue;
      Observation seen;
      measure(view, image, detected_[k], seen);
      if (!seen.valid) continue;
      for (auto& member : members) {
        const auto& point = points.landmarks()[static_cast<std::size_t>(member.hint)];
        member.offset_px = seen.segment.distance(point.current.pixel);
        member.offset = 2 * S(member.offset_px) / seen.pixels.measured.px_per_rad.sum();
      }
      Landmark* line = recognize(view, window, store, slot, members, points, seen);
      if (line != nullptr) {
        if (line->current.from_points || !line->current.valid) {  // else it has a longer segment already
          line->current = seen;
          line->observations[static_cast<std::size_t>(slot)] = seen;
        }
        line->misses = 0;
        add_members(line->appearance.points, members);
      } else if (store.seen_count() < options_.target_count) {
        Landmark landmark;
        landmark.current = seen;
        landmark.appearance.points = members;
        landmark.anchor = slot;
        landmark.observations[static_cast<std::size_t>(slot)] = seen;
        locate_collinear(view.T_body_cam, window, landmark, points);
        if (!store.add(landmark, slot)) break;
      }
    }
  }

 private:
  static const auto& points_of(const auto& before) {
    return std::apply(
        [](const auto&... stores) -> const auto& { return held_of<Kind>(stores...); }, before);
  }

  // ------------------------------------------------------------------------------------------------ members

  /// A line without two points is nobody any more.
  static void forget_members(Landmark& landmark, const auto& points) {
    Members& members = landmark.appearance.points;
    for (std::size_t k = members.size(); k-- > 0;) {
      if (index_of(points, members[k]) < 0) members.swap_remove(k);
    }
    if (members.size() < 2) landmark.located = landmark.current.valid = false;
  }
  static void add_members(Members& to, const Members& more) {
    for (const auto& member : more) {
      const auto known = std::find_if(to.begin(), to.end(), [&](const auto& other) { return other.id == member.id; });
      if (known == to.end()) {
        to.push_back(member);  // as many as there is room for
      } else {
        known->offset_px = member.offset_px;
      }
    }
  }

  /// Whether two of the points are far enough apart, in the latest image and, of those that it shows, in that of the
  /// keyframe in `*slot`.
  bool are_apart(Members& members, const auto& points, const int* slot) const {
    for (std::size_t a = 0; a < members.size(); ++a) {
      const auto& first = points.landmarks()[static_cast<std::size_t>(index_of(points, members[a]))];
      for (std::size_t b = 0; b < a; ++b) {
        const auto& second = points.landmarks()[static_cast<std::size_t>(index_of(points, members[b]))];
        if (!(norm(first.current.pixel - second.current.pixel) > options_.separation_px)) continue;
        if (slot == nullptr) return true;
        const auto &then = first.observations[static_cast<std::size_t>(*slot)],
                   &there = second.observations[static_cast<std::size_t>(*slot)];
        if (!then.valid || !there.valid || norm(then.pixel - there.pixel) > options_.separation_px) return true;
      }
    }
    return false;
  }

  // ------------------------------------------------------------------------------------------------ what is seen

  /// The segment between the outermost members in sight, each moved by as much as it was beside the segment.
  void see_members(const View<Sensors>& view, Landmark& landmark, const auto& points) const {
    const LineSegment before = landmark.previous.valid ? landmark.previous.segment : landmark.seen_by_anchor().segment;
    const Vec<float, 2> d = before.direction(), n_px = before.normal();
    LineSegment segment;
    float from = 0, to = 0, sigma_start = 0, sigma_end = 0;
    int n = 0;
    for (auto& member : landmark.appearance.points) {
      const int i = index_of(points, member);
      if (i < 0) continue;
      const auto& point = points.landmarks()[static_cast<std::size_t>(i)];
      if (!point.current.valid) continue;
      const float along = dot(d, point.current.pixel);
      const Vec<float, 2> on_line = point.current.pixel - member.offset_px * n_px;
      if (n == 0 || along < from) {
        from = along;
        segment.start = on_line;
        sigma_start = sigma_across(point.current.L, n_px);
      }
      if (n == 0 || along > to) {
        to = along;
        segment.end = on_line;
        sigma_end = sigma_across(point.current.L, n_px);
      }
      ++n;
    }
    landmark.current.valid = false;
    if (n < 2 || !(to - from > options_.separation_px)) return;
    const float widened = float(options_.sigma_points * options_.sigma_points);
    Mat<float, 2, 2> covariance = zeros<float, 2, 2>();
    covariance(0, 0) = widened * sigma_start * sigma_start;
    covariance(1, 1) = widened * sigma_end * sigma_end;
    measure_segment(view, segment, covariance, landmark.current);
    landmark.current.from_points = true;
    if (landmark.current.valid) landmark.misses = 0;
  }
  /// Of a pixel with the information L^T L, along n [px].
  static float sigma_across(const Mat<float, 2, 2>& L, const Vec<float, 2>& n) {
    // L is upper triangular: L^-T n by forward substitution.
    const float a = n[0] / L(0, 0), b = (n[1] - L(0, 1) * a) / L(1, 1);
    return std::hypot(a, b);
  }

  /// A detected segment by the edge below it.
  void measure(const View<Sensors>& view, const ImageView<const std::uint8_t>& image, const LineSegment& segment,
               Observation& out) {
    const TrackedLine tracked = tracker_.track(edges_, image, profile_of(image, segment), segment, options_.tracking);
    out.valid = out.from_points = false;
    if (!tracked.valid) return;
    const float peaks = std::max(1.0f, tracked.support * tracked.segment.length() / options_.peak_spacing_px);
    measure_segment(view, tracked.segment, endpoint_covariance(options_.sigma_px, tracked.rms_px, peaks), out);
  }

  // ------------------------------------------------------------------------------------------------ recognition

  /// The line that a segment of the keyframe in `slot` with these members belongs to; others that it belongs to become
  /// part of that one.
  Landmark* recognize(const View<Sensors>& view, const auto& window, Store& store, int slot, const Members& members,
                      const auto& points, const Observation& seen) {
    Landmark* found = nullptr;
    std::size_t most = 0;
    for (Landmark& landmark : store.landmarks()) {
      Members shared = shared_of(members, landmark.appearance.points);
      if (shared.size() < 2 || !are_apart(shared, points, &landmark.anchor)) continue;
      if (!agrees(view, window, landmark, slot, seen)) continue;
      const bool better =
          found == nullptr || (landmark.located != found->located ? landmark.located : shared.size() > most);
      Landmark* other = better ? found : &landmark;
      if (better) {
        found = &landmark;
        most = shared.size();
      }
      if (other != nullptr && other->located && found->located) merge(view, window, *found, *other);
    }
    return found;
  }
  static Members shared_of(const Members& a, const Members& b) {
    Members out;
    for (const auto& member : a) {
      const auto is_it = [&](const auto& other) { return other.id == member.id; };
      if (std::any_of(b.begin(), b.end(), is_it)) out.push_back(member);
    }
    return out;
  }

  /// Whether a line is seen where the frame in `slot` has a segment, and is bright on the same side; only the latter
  /// when its place is not known.
  bool agrees(const View<Sensors>& view, const auto& window, const Landmark& landmark, int slot,
              const Observation& seen) const {
    if (!landmark.located) return dot(landmark.seen_by_anchor().segment.direction(), seen.segment.direction()) > 0;
    const SE3<S> T_cam_anchor = (window.T_world_body(slot) * view.T_body_cam).inverse() *
                                (window.T_world_body(landmark.anchor) * view.T_body_cam);
    const Plucker<S> line = T_cam_anchor * landmark.geometry.line.plucker();
    const LineReprojection<S>& pixels = seen.pixels.measured;
    const Vec<S, 2> r = pixels.residual(line);
    return std::abs(r[0]) < S(options_.same_line_px) && std::abs(r[1]) < S(options_.same_line_px) &&
           dot(line.n, pixels.bearing_start.cross(pixels.bearing_end)) > S(0);
  }
  /// The segments and points of one line become those of another, if it is seen where all of them are.
  void merge(const View<Sensors>& view, const auto& window, Landmark& line, Landmark& other) const {
    for (int k = 0; k < Store::slots; ++k) {
      const Observation& seen = other.observations[static_cast<std::size_t>(k)];
      if (seen.valid && !seen.from_points && !agrees(view, window, line, k, seen)) return;
    }
    for (std::size_t k = 0; k < std::size_t(Store::slots); ++k) {
      const Observation& seen = other.observations[k];
      Observation& own = line.observations[k];
      if (seen.valid && !seen.from_points && (!own.valid || own.from_points)) own = seen;
    }
    add_members(line.appearance.points, other.appearance.points);
    other.appearance.points.clear();
    other.located = other.current.valid = false;
  }

  Options options_;
  EdgeMap<decltype(Sensors::vision)::max_pixels> edges_;
  LineTracker tracker_;
  Detector detector_;
  FixedVector<LineSegment, 300> detected_;
  PointsOnSegments<Members> on_segments_;
};

}  // namespace plumbline
