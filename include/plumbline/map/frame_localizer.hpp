#pragma once
/// The pose of a single frame in the map: what a camera that is lost knows of its place.          docs/math/map.md 6
///
/// The pose of the frame in a local map (local_map.hpp) is that of place_pose.hpp. Points that agree are followed into
/// the next images (frame_tracks.hpp). The local map is that of the pose of the frame before, where the map has told
/// it, else those of the keyframes that look most like the frame, of each place one. A pose counts when the frame
/// before had one that a moving camera can have come from, and when no other place gives one, too.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/map/frame_tracks.hpp"
#include "plumbline/map/local_map.hpp"
#include "plumbline/map/place_index.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/place_pose.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"
#include "plumbline/tracking/descriptor_matching.hpp"
#include "plumbline/tracking/optical_flow.hpp"

namespace plumbline {

struct FrameLocalizerOptions {
  int places = 3;  ///< that look most like the frame, of which its pose is tried
  LocalMapOptions local;
  double max_gap_s = 0.5;  ///< between two frames that are to agree
  double max_rate = 6;     ///< of the camera between them [rad/s]
  double max_speed = 2;    ///< [mean ranges/s]
  double max_turn = 0.1;   ///< between two poses of one frame that are the same place [rad]
  /// Of the features' sigmas, for what they do not tell: blur, a rolling shutter, ranges of short baselines. The
  /// covariance of the pose is that of the errors that remain, at least of the sigmas themselves.
  double sigma_factor = 3;
  double track_sigma_px = 1;  ///< of a point that is followed
  OpticalFlowOptions flow;
};

template <class Places>
class FrameLocalizer {
 public:
  using S = typename Places::S;
  static constexpr std::size_t max_features = 2 * Places::max_features;  ///< of a frame, and of a local map
  static constexpr std::size_t max_candidates = 12;
  using Frame = PlaceKeyframe<S, max_features>;
  using Local = LocalMap<Places, max_features>;

  struct Pose {
    bool valid = false;
    SE3<S> T_map_cam;                            ///< in the unit of the map
    Mat<S, 6, 6> covariance = zeros<S, 6, 6>();  ///< of its right increment
    S mean_range = S(1);                         ///< of the local map
    int inliers = 0;
    TimeNs t_ns = 0;
  };

  explicit FrameLocalizer(const FrameLocalizerOptions& options) : options_(options) {}

  /// A frame to be given its features; `find` follows.
  Frame& begin_frame() {
    frame_.features.clear();
    return frame_;
  }
  /// The pose of the frame by those keyframes that `accept(keyframe)` holds for. nullptr without one that counts.
  /// `R_cur_prev`: rotation that is expected of the camera since the previous image. `is_ambiguous` is set where more
  /// places give a pose; they are `min_alias` mean ranges from one another.
  template <class View, class Index>
  const Pose* find(const View& view, const SO3<S>& R_cur_prev, const Places& places, Index& index,
                   const PlacePoseOptions& pose, double range_error, double min_alias, auto&& accept,
                   bool& is_ambiguous) {
    is_ambiguous = false;
    for (PlaceFeature& feature : frame_.features) feature.sigma_rad *= float(options_.sigma_factor);
    const S gap_s = S(seconds_between(last_.t_ns, view.t_ns));
    const bool follows = last_.valid && gap_s <= S(options_.max_gap_s);
    tracks_.follow(view, R_cur_prev, options_.flow);
    if (!follows) tracks_.clear();
    Pose found;
    if (follows) {
      const Pose tracked = solve_tracks(view, last_.T_map_cam, pose, range_error);
      found = solve(places, tracked.valid ? tracked.T_map_cam : last_.T_map_cam, pose, range_error, accept);
      if (tracked.valid && (!found.valid || are_apart(tracked, found, S(min_alias)))) {
        found = tracked;
        matched_.clear();
      }
    }
    if (!found.valid) {
      tracks_.clear();
      found = recognize(places, index, pose, range_error, min_alias, accept, is_ambiguous);
    }
    if (found.valid) found = with_tracks(view, found, pose, range_error);
    found.t_ns = view.t_ns;
    const bool counts = found.valid && follows && is_near(last_, found, gap_s);
    if (found.valid || !follows) last_ = found;
    return counts ? &last_ : nullptr;
  }
  /// The map has changed.
  void forget() {
    last_ = {};
    tracks_.clear();
  }

 private:
  /// The places of the keyframes that look most like the frame.
  template <class Index>
  Pose recognize(const Places& places, Index& index, const PlacePoseOptions& pose, double range_error, double min_alias,
                 const auto& accept, bool& is_ambiguous) {
    descriptors_.clear();
    for (const PlaceFeature& feature : frame_.features) descriptors_.push_back(feature.descriptor);
    std::array<PlaceCandidate, max_candidates> candidates;
    const std::size_t count = index.query({descriptors_.data(), descriptors_.size()}, candidates,
                                          [&](std::uint32_t slot) { return accept(places.in_slot(int(slot))); });
    Pose best;
    is_tried_.fill(false);
    int tried = 0;
    for (std::size_t n = 0; n < count && tried < options_.places; ++n) {
      int k = 0;
      while (k < places.size() && places.slot(k) != int(candidates[n].id)) ++k;
      if (k == places.size() || is_tried_[std::size_t(k)]) continue;
      ++tried;
      const Sim3<S> S_map_cam = Local::camera_in_map(places, k);
      const Pose found = solve(places, SE3<S>(S_map_cam.rotation(), S_map_cam.t()), pose, range_error, accept);
      if (!found.valid) continue;
      if (best.valid && are_apart(best, found, S(min_alias))) {
        is_ambiguous = true;
        return {};
      }
      if (found.inliers > best.inliers) best = found;
    }
    if (best.valid) best = solve(places, best.T_map_cam, pose, range_error, accept);
    return best;
  }

  /// The pose in the local map of a camera at T_map_cam.
  Pose solve(const Places& places, const SE3<S>& T_map_cam, const PlacePoseOptions& options, double range_error,
             const auto& accept) {
    local_.collect(places, T_map_cam, frame_, options_.local, S(options.max_relative_sigma), accept,
                   [this](int k) { is_tried_[std::size_t(k)] = true; });
    for (PlaceFeature& feature : local_.keyframe.features) feature.sigma_rad *= float(options_.sigma_factor);
    return in_map(solver_.solve(local_.keyframe, frame_, local_.T_map_local.inverse() * T_map_cam, options),
                  range_error);
  }
  Pose in_map(const PlacePose<S>& found, double range_error) {
    Pose out;
    matched_.clear();
    if (!found.valid) return out;
    for (const DescriptorMatch& match : solver_.inliers()) matched_.push_back(match);
    out.valid = true;
    out.T_map_cam = local_.T_map_local * found.T_old_current;
    out.inliers = found.inliers;
    out.mean_range = local_.keyframe.mean_range();
    const S factor2 = S(options_.sigma_factor * options_.sigma_factor);
    out.covariance = std::clamp(found.noise2, S(1) / factor2, S(1)) * found.covariance;
    const SE3<S>& T = found.T_old_current;  // map.md (3a)
    const Vec<S, 3> shared = S(range_error) * (T.rotation().inverse() * T.p());
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) out.covariance(3 + a, 3 + b) += shared[a] * shared[b];
    return out;
  }

  /// The pose by the tracks alone; others are removed.
  template <class View>
  Pose solve_tracks(const View& view, const SE3<S>& T_map_cam, const PlacePoseOptions& options, double range_error) {
    local_.keyframe.features.clear();
    seen_.features.clear();
    const SE3<S> T_local_map = local_.T_map_local.inverse();
    const float sigma_rad = float(options_.track_sigma_px / double(effective_focal_length(view.camera())));
    tracks_.keep_if([&](std::size_t i) {
      const FrameTrack<S>& track = tracks_.tracks()[i];
      const auto ray = view.camera().unproject(cast_to<S>(track.pixel));
      const Vec<S, 3> p = T_local_map * track.p_map;
      const S range = norm(p);
      if (!ray.valid || !(range > S(0))) return false;
      PlaceFeature feature = track.in_keyframe;
      feature.bearing = cast_to<float>(Vec<S, 3>(p / range));
      feature.range = float(range);
      local_.keyframe.features.push_back(feature);
      feature.bearing = cast_to<float>(ray.bearing);
      feature.range = 0;
      feature.sigma_rad = sigma_rad * float(options_.sigma_factor);
      seen_.features.push_back(feature);
      return true;
    });
    const Pose out =
        in_map(solver_.solve_matched(local_.keyframe, seen_, T_local_map * T_map_cam, options), range_error);
    if (!out.valid) return out;
    std::size_t next = 0;
    tracks_.keep_if([&](std::size_t i) {
      while (next < matched_.size() && matched_[next].first < i) ++next;
      return next < matched_.size() && matched_[next].first == i;
    });
    return out;
  }
  /// The points of the frame that agree with its pose are followed from now on; the pose is that of all of them.
  template <class View>
  Pose with_tracks(const View& view, const Pose& found, const PlacePoseOptions& options, double range_error) {
    for (const DescriptorMatch& match : matched_) {
      const PlaceFeature &a = local_.keyframe.features[match.first], &b = frame_.features[match.second];
      const auto seen = view.camera().project(cast_to<S>(b.bearing));
      if (seen.valid)
        tracks_.add({local_.T_map_local * Vec<S, 3>(S(a.range) * cast_to<S>(a.bearing)), cast_to<float>(seen.uv), a});
    }
    const Pose all = solve_tracks(view, found.T_map_cam, options, range_error);
    return all.valid ? all : found;
  }

  bool are_apart(const Pose& a, const Pose& b, S min_alias) const {
    const SE3<S> T = a.T_map_cam.inverse() * b.T_map_cam;
    return !(norm(T.p()) < min_alias * a.mean_range) || !(norm(T.rotation().log()) < S(options_.max_turn));
  }
  /// Whether a camera can have moved from a to b in that time.
  bool is_near(const Pose& a, const Pose& b, S gap_s) const {
    const SE3<S> T = a.T_map_cam.inverse() * b.T_map_cam;
    S turned2 = S(0), moved2 = S(0);
    for (int k = 0; k < 3; ++k) {
      turned2 += a.covariance(k, k) + b.covariance(k, k);
      moved2 += a.covariance(3 + k, 3 + k) + b.covariance(3 + k, 3 + k);
    }
    const S turn = S(options_.max_rate) * gap_s + S(3) * std::sqrt(turned2),
            move = S(options_.max_speed) * gap_s * a.mean_range + S(3) * std::sqrt(moved2);
    return norm(T.rotation().log()) < turn && norm(T.p()) < move;
  }

  FrameLocalizerOptions options_;
  Pose last_;
  Frame frame_, seen_;
  Local local_;
  FixedVector<DescriptorMatch, max_features> matched_;  ///< (of the local map, of the frame), of the last pose
  FrameTracks<S, max_features / 2> tracks_;
  std::array<bool, std::size_t(Places::max_keyframes)> is_tried_{};  ///< its place, of the present frame
  FixedVector<BinaryDescriptor, max_features> descriptors_;
  PlacePoseSolver<S, max_features> solver_;
};

/// Of maps that do not look for frames.
struct NoFrameLocalizer {
  NoFrameLocalizer(auto&&...) {}
  static void forget() {}
};

}  // namespace plumbline
