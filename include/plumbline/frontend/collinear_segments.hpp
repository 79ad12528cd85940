#pragma once
/// Front end of lines through points, by segments detected in keyframes.                    docs/math/collinear.md
///
/// In a keyframe segments are detected, and points close to a segment become its members. A segment that shares two
/// members, far enough apart, with a known line is an observation of that line if their positions in space agree; of
/// its appearance only the bright side is used. Lines that share a segment are merged. Between keyframes the outermost
/// members in view replace the segment.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tuple>

#include "plumbline/core/elementary.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/collinear_kind.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/frontend/collinear_location.hpp"
#include "plumbline/frontend/collinear_options.hpp"
#include "plumbline/frontend/points_on_segments.hpp"
#include "plumbline/frontend/segment_measurement.hpp"
#include "plumbline/tracking/edge_map.hpp"
#include "plumbline/tracking/line_detector.hpp"
#include "plumbline/tracking/line_tracking.hpp"

namespace plumbline {

template <class Store, LineDetector Detector = LineSegmentDetector<>>
class CollinearSegments {
 public:
  using Kind = typename Store::Kind;
  using Sensors = typename Kind::Sensors;
  using S = typename Kind::S;
  using Landmark = typename Store::Landmark;
  using Observation = typename Kind::Observation;
  using Members = decltype(Kind::Appearance::points);
  using Options = CollinearOptionsOf<Sensors>;
  static constexpr bool gives_correspondences = false;
  static constexpr bool reads_kinds_before = true;

  explicit CollinearSegments(const CollinearOptions& options) : options_(options) {}

  /// Observes all lines by their members.
  void follow(const View<Sensors>& view, const auto& /*window*/, Store& store, const SE3<S>& /*T_world_predicted*/,
              const auto& before) {
    const auto& points = points_of(before);
    for (Landmark& landmark : store.landmarks()) {
      remove_lost_members(landmark, points);
      observe_members(view, landmark, points);
      if (!landmark.current.valid) ++landmark.misses;
    }
  }

  /// Observes all lines by the corrected members, and updates their extents.
  void refine(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& T_world_body,
              const auto& before) {
    const auto& points = points_of(before);
    const SE3<S> T_cam_world = (T_world_body * view.T_body_cam).inverse();
    for (Landmark& landmark : store.landmarks()) {
      observe_members(view, landmark, points);
      if (!landmark.current.valid || !landmark.located) continue;
      const LineReprojection<S>& seen = landmark.current.pixels.measured;
      landmark.geometry.set_extent(T_cam_world * (window.T_world_body(landmark.anchor) * view.T_body_cam),
                                   seen.bearing_start, seen.bearing_end);
    }
  }

  /// Locates lines whose members were located.
  void locate(const View<Sensors>& view, const auto& window, Store& store, const SE3<S>& /*T_world_body*/,
              const auto& before) {
    for (Landmark& landmark : store.landmarks()) {
      if (!landmark.located && landmark.current.valid)
        locate_collinear(view.T_body_cam, window, landmark, points_of(before));
    }
  }

  /// Detects segments in a keyframe: observations of known lines, and new lines.
  void detect(const View<Sensors>& view, const auto& window, Store& store, int slot, const auto& before) {
    const auto& points = points_of(before);
    const ImageView<const std::uint8_t>& image = view.current.level(0);
    if (!edges_.compute(image, options_.detector.min_gradient, view.current.mask())) return;
    detector_.detect(image, edges_, options_.detector, detected_);
    if (!edges_.compute(image, options_.detector.min_gradient, view.current.mask()))
      return;  // the detector may have consumed them
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
        if (line->current.from_points || !line->current.valid) {  // else a longer segment was assigned before
          line->current = seen;
          line->observations[static_cast<std::size_t>(slot)] = seen;
        }
        line->misses = 0;
        add_members(line->appearance.points, members);
      } else if (members.size() >= options_.min_points && store.seen_count() < options_.target_count) {
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
        [](const auto&... stores) -> const auto& { return member_store_of<Kind>(stores...); }, before);
  }

  // ------------------------------------------------------------------------------------------------ members

  /// Removes members that are no longer in their store; a line with too few is discarded.
  void remove_lost_members(Landmark& landmark, const auto& points) const {
    Members& members = landmark.appearance.points;
    for (std::size_t k = members.size(); k-- > 0;) {
      if (index_of(points, members[k]) < 0) members.swap_remove(k);
    }
    if (members.size() < std::max<std::size_t>(options_.min_points, 2))
      landmark.located = landmark.current.valid = false;
  }
  static void add_members(Members& to, const Members& more) {
    for (const auto& member : more) {
      const auto known = std::find_if(to.begin(), to.end(), [&](const auto& other) { return other.id == member.id; });
      if (known == to.end()) {
        to.push_back(member);  // up to the capacity
      } else {
        known->offset_px = member.offset_px;
      }
    }
  }

  /// Whether two of the members are far enough apart in the latest image and, if both were observed there, in that of
  /// the keyframe in `*slot`.
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

  // ------------------------------------------------------------------------------------------------ observation

  /// Observes a line by the segment between its outermost members in view, each corrected by its distance to the
  /// segment.
  void observe_members(const View<Sensors>& view, Landmark& landmark, const auto& points) const {
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
  /// Sigma along n of a pixel with the information L^T L [px].
  static float sigma_across(const Mat<float, 2, 2>& L, const Vec<float, 2>& n) {
    // L is upper triangular: L^-T n by forward substitution.
    const float a = n[0] / L(0, 0), b = (n[1] - L(0, 1) * a) / L(1, 1);
    return elementary::hypot(a, b);
  }

  /// Measures a detected segment by its edge in the image.
  void measure(const View<Sensors>& view, const ImageView<const std::uint8_t>& image, const LineSegment& segment,
               Observation& out) {
    const TrackedLine tracked = tracker_.track(edges_, image, profile_of(image, segment), segment, options_.tracking);
    out.valid = out.from_points = false;
    if (!tracked.valid) return;
    const float peaks = std::max(1.0f, tracked.support * tracked.segment.length() / options_.peak_spacing_px);
    measure_segment(view, tracked.segment, endpoint_covariance(options_.sigma_px, tracked.rms_px, peaks), out);
  }

  // ------------------------------------------------------------------------------------------------ recognition

  /// The known line of a segment of the keyframe in `slot` with these members, or null; further lines of the same
  /// segment are merged into it.
  Landmark* recognize(const View<Sensors>& view, const auto& window, Store& store, int slot, const Members& members,
                      const auto& points, const Observation& seen) {
    Landmark* found = nullptr;
    std::size_t most = 0;
    for (Landmark& landmark : store.landmarks()) {
      Members shared = shared_of(members, landmark.appearance.points);
      if (shared.size() < 2 || !are_apart(shared, points, &landmark.anchor)) continue;
      if (!fits_segment(view, window, landmark, slot, seen)) continue;
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

  /// Whether the projection of a line agrees with a segment of the frame in `slot`, with the same bright side; the
  /// latter alone for a line that is not located.
  bool fits_segment(const View<Sensors>& view, const auto& window, const Landmark& landmark, int slot,
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
  /// Moves segments and members of `other` to `line`, if the projection of `line` agrees with all of these segments.
  void merge(const View<Sensors>& view, const auto& window, Landmark& line, Landmark& other) const {
    for (int k = 0; k < Store::slots; ++k) {
      const Observation& seen = other.observations[static_cast<std::size_t>(k)];
      if (seen.valid && !seen.from_points && !fits_segment(view, window, line, k, seen)) return;
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

  CollinearOptions options_;
  EdgeMap<decltype(Sensors::vision)::max_pixels> edges_;
  LineTracker tracker_;
  Detector detector_;
  FixedVector<LineSegment, 300> detected_;
  PointsOnSegments<Members> on_segments_;
};

}  // namespace plumbline
