#pragma once
/// What a map of keyframes does with them, whoever describes their features.                       docs/math/map.md
///
/// learn:    descriptors of a new keyframe, ranges of its landmarks; node and edge of the pose graph
///           (kept_keyframes.hpp)
/// query:    the retired keyframes that look most like the newest one (loop_candidates.hpp)
/// verify:   pose in the older keyframe and the tests of a loop (loop_finder.hpp); two keyframes in a row agree
/// solve:    pose graph (graph_solution.hpp): heading and position with an IMU, SE(3) with depth, else Sim(3)
/// Frames without a pose of their own are found in the map one by one (frame_localizer.hpp), of rigs without an IMU.
/// A map may be saved and taken in by another run (place_archive.hpp), which extends it, or only finds itself in it
/// (map_localizer.hpp). Query, each candidate, and slices of the solution are done one a frame, chosen by counts: the
/// same input gives the same output.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/found_frame.hpp"
#include "plumbline/map/frame_localizer.hpp"
#include "plumbline/map/graph_solution.hpp"
#include "plumbline/map/kept_keyframes.hpp"
#include "plumbline/map/keyframe_map_counts.hpp"
#include "plumbline/map/keyframe_map_options.hpp"
#include "plumbline/map/local_adjustment.hpp"
#include "plumbline/map/loop_candidates.hpp"
#include "plumbline/map/loop_finder.hpp"
#include "plumbline/map/loop_insertion.hpp"
#include "plumbline/map/map_localizer.hpp"
#include "plumbline/map/map_points.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/map/world_change.hpp"

namespace plumbline {

template <RelativeResidual Residual, int MaxKeyframes, std::size_t MaxFeatures, int MaxLoops, bool FindsPoints = false,
          int MaxPoints = 40 * MaxKeyframes>
class KeyframeMapCore {
 public:
  using Places = PlaceGraph<Residual, MaxKeyframes, MaxFeatures, MaxLoops>;
  using S = typename Places::S;
  using Pose = typename Places::Pose;
  using Keyframe = typename Places::Keyframe;
  using Covariance = typename Places::Covariance;
  static constexpr int none = Places::none;
  enum class Stage : std::uint8_t { query, verify, solve, adjust };
  /// Points of the map are found again, and keyframes adjusted with them.
  static constexpr bool has_points = FindsPoints;
  /// Single frames are found in the map.
  static constexpr bool finds_frames = !Places::has_gravity;
  using Points = std::conditional_t<has_points, MapPoints<Places, MaxPoints>, NoMapPoints>;

  explicit KeyframeMapCore(const KeyframeMapOptions& options)
      : options_(options),
        kept_(options.graph),
        finder_(options),
        frames_(options.frames),
        adjustment_(options.neighborhood) {}

  const Places& places() const { return kept_.places(); }
  Places& places() { return kept_.places(); }
  Points& points() { return kept_.points(); }
  const KeyframeMapCounts& counts() const { return counts_; }
  void count_recalled(std::size_t points) { counts_.recalled += int(points); }
  /// Correction of the present world; counts().corrections tells how often it has changed.
  Sim3<S> S_map_world() const { return places().S_map_world(); }
  /// Covariance of the newest keyframe's pose in the map, see map_correction.hpp; false where it is not known.
  bool covariance_in_map(Covariance& out) const {
    return places().size() > 0 && kept_.correction().covariance(places(), places().size() - 1, out);
  }

  /// sink(std::span<const std::byte>) gets the bytes of the map, place_archive.hpp. In any state.
  template <class Sink>
  void save(Sink&& sink) const {
    kept_.save(sink);
  }
  /// Takes a saved map in, before the first frame. On an error nothing has changed.
  MapArchiveError load(std::span<const std::byte> bytes) {
    return kept_.load(bytes, MaxKeyframes - (options_.localize_only ? run_keyframes : 0));
  }
  /// Keyframes that were taken in, before those of this run.
  int loaded() const { return kept_.loaded(); }
  /// Whether the present world has its place in the map that was taken in; true without one.
  bool is_in_map() const {
    return loaded() == 0 || is_frame_found_ || localizer_.is_localized() || is_connected(places(), places().world());
  }

  /// Keyframes are known by the sequence of their frames.
  void set_pose(std::uint32_t id, const SE3<S>& T_world_body) { places().set_pose(kept_.id_of(id), T_world_body); }
  void set_covariance(std::uint32_t a, std::uint32_t b, const Mat<S, 6, 6>& covariance) {
    places().set_covariance(kept_.id_of(a), kept_.id_of(b), covariance);
  }
  /// A new keyframe, to be given its features; nullptr when it is refused. `finish_keyframe` ends it.
  Keyframe* begin_keyframe(std::uint32_t id, TimeNs t_ns, const SE3<S>& T_world_body, const SE3<S>& T_body_cam,
                           const Mat<S, 6, 6>& covariance) {
    if (options_.localize_only && places().size() - loaded() >= run_keyframes) kept_.remove_oldest();
    if (places().size() == MaxKeyframes) evict();
    return kept_.begin(id, t_ns, T_world_body, T_body_cam, covariance);
  }
  /// True where its places will be asked for.
  bool finish_keyframe() {
    const Keyframe& keyframe = kept_.finish();
    if (stage_ != Stage::query) return false;
    wanted_ = keyframe.id;
    return true;
  }
  Keyframe* retire(std::uint32_t id, const SE3<S>& T_world_body) {
    Keyframe* const retired = kept_.retire(id, T_world_body);
    if (retired) is_unadjusted_ = true;
    return retired;
  }
  void change_world(const WorldChange<S>& change) {
    using Kind = typename WorldChange<S>::Kind;
    abandon();
    switch (change.kind) {
      case Kind::transformed:
        places().transform(change.S_new_old, change.T_body_cam);
        finder_.forget_aliases();
        kept_.correction().forget();
        is_initialized_ = true;
        break;
      case Kind::rejected: kept_.remove_present_world(); break;
      case Kind::reset:
        if (Places::has_gravity && !is_initialized_)
          kept_.remove_present_world();  // its axes and unit are not the map's
        places().begin_world();
        is_initialized_ = false;
        break;
    }
  }

  /// What work() does next.
  Stage stage() const { return stage_; }
  /// One slice: a query, a candidate, or a part of the solution. `align(slot, keyframe, T, visit)`: place_pose.hpp, for
  /// the keyframe in that slot and the last one for which `finish_keyframe` was true.
  void work(const auto& align) {
    is_frame_found_ = false;
    switch (stage_) {
      case Stage::query: return query();
      case Stage::verify: return verify(align);
      case Stage::solve: return solve();
      case Stage::adjust: return adjust();
    }
  }
  void work() {
    work([](auto&&...) {});
  }

  /// A frame to be given its features; `find_frame` follows.
  auto& begin_frame() { return frames_.begin_frame(); }
  /// The pose of the frame that was given its features.
  template <class View>
  bool find_frame(const View& view, const SO3<S>& R_cur_prev, FoundFrame<S>& found) {
    if (stage_ == Stage::query) places().update();
    bool is_ambiguous = false;
    const auto* const pose = frames_.find(
        view, R_cur_prev, places(), kept_.index(), options_.pose, options_.common_range_error, options_.min_alias,
        [this](const Keyframe& keyframe) { return can_be_recognized(keyframe); }, is_ambiguous);
    ++counts_.frames_asked;
    counts_.rejected_as_ambiguous += is_ambiguous;
    if (!pose || finder_.knows_aliases()) return false;
    const Sim3<S> S_world_map = S_map_world().inverse();
    const SE3<S> T_world_cam(S_world_map.rotation() * pose->T_map_cam.rotation(), S_world_map * pose->T_map_cam.p());
    Mat<S, 6, 6> P = pose->covariance;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        P(i, j) *= (i < 3 ? S(1) : S_world_map.scale()) * (j < 3 ? S(1) : S_world_map.scale());
    found.T_world_body = T_world_cam * view.T_body_cam.inverse();
    found.covariance = transported(P, T_world_cam, found.T_world_body);
    found.inliers = pose->inliers;
    ++counts_.frames_found;
    return is_frame_found_ = true;
  }

 private:
  using Loop = PlaceLoop<Places>;
  static constexpr std::uint32_t nothing = Loop::nothing;
  /// Of this run where the map is only read: more than a window, and not more than half of what there is room for.
  static constexpr int run_keyframes = std::min(40, MaxKeyframes / 2);

  /// Ends what is going on: keyframes change.
  void abandon() {
    stage_ = Stage::query;
    wanted_ = nothing;
    localizer_.reset();
    last_ = {};
  }
  void evict() {
    if (options_.localize_only) return;
    const int k = places().most_redundant();
    if (k == none) return;
    if (stage_ == Stage::solve) is_unsolved_ = true;
    stage_ = Stage::query;
    counts_.evicted += kept_.remove(k);
  }

  /// A map that is only read is not found by keyframes of this run.
  bool can_be_recognized(const Keyframe& keyframe) const {
    return keyframe.is_retired && (!options_.localize_only || kept_.is_loaded(keyframe));
  }
  void query() {
    Places& places = kept_.places();
    if (std::exchange(is_unsolved_, false) && places.graph().loops() > 0) return begin_solution();
    const int j = wanted_ == nothing ? none : places.find(std::exchange(wanted_, nothing));
    if (j == none || (Places::has_gravity && !is_initialized_)) return begin_adjustment();
    if (last_.is_inserted && places.find(last_.j) != none && j - places.find(last_.j) < options_.loop_spacing) return;
    places.update();
    candidates_.query(kept_.index(), places, j, kept_.descriptors_of(places.keyframe(j)), options_.min_score,
                      [this](const Keyframe& keyframe) { return can_be_recognized(keyframe); });
    ++counts_.queries;
    if (candidates_.any()) stage_ = Stage::verify;
  }

  void verify(const auto& align) {
    Places& places = kept_.places();
    const int j = candidates_.asked(places);
    if (j == none || candidates_.all_taken()) return end_query();
    const int i = candidates_.take(places, j);
    if (i == none) return;
    Loop loop;
    if (!finder_.find(places, i, j, loop, counts_, align)) return;
    ++counts_.verified;
    const bool has_agreed = finder_.agrees(places, last_, loop);
    if (has_agreed && !options_.localize_only) points().join(places, i, j, finder_.matches());
    if (options_.localize_only) return localize(loop, has_agreed);
    if (has_agreed && (last_.is_inserted || insert_loop(places, last_, counts_)) &&
        insert_loop(places, loop, counts_)) {
      loop.is_inserted = true;
      last_ = loop;
      return begin_solution();
    }
    last_ = loop;
    end_query();
  }
  void end_query() { stage_ = Stage::query; }
  /// The map stays; the present world moves.
  void localize(const Loop& loop, bool has_agreed) {
    const bool was_localized = localizer_.is_localized();
    if (has_agreed && localizer_.add(places(), loop, options_.gate)) {
      places().join(places().find(loop.j), localizer_.pose());
      ++counts_.loops;
      ++counts_.corrections;
      kept_.correction().set(loop.j, localizer_.covariance(), true);
      counts_.relocalizations += !was_localized;
    }
    last_ = loop;
    end_query();
  }

  void begin_solution() {
    solution_.begin(kept_.places());
    stage_ = Stage::solve;
  }
  void solve() {
    if (!solution_.iterate(options_.solver_budget)) return;
    stage_ = Stage::query;
    counts_.corrections += solution_.apply(kept_.places(), kept_.correction());
  }
  void begin_adjustment() {
    if constexpr (has_points) {
      if (options_.localize_only || !std::exchange(is_unadjusted_, false)) return;
      int k = places().size() - 1;
      while (k >= 0 && !places().keyframe(k).is_retired) --k;
      if (k < 0 || places().keyframe(k).world != places().world()) return;
      places().update();
      if (adjustment_.begin(places(), k)) stage_ = Stage::adjust;
    }
  }
  void adjust() {
    if constexpr (has_points) {
      if (!adjustment_.iterate(options_.adjustment_budget)) return;
      stage_ = Stage::query;
      adjustment_.apply(places());
      ++counts_.adjustments;
    }
  }

  KeyframeMapOptions options_;
  KeyframeMapCounts counts_;
  Stage stage_ = Stage::query;
  bool is_initialized_ = false, is_unsolved_ = false, is_unadjusted_ = false, is_frame_found_ = false;
  std::uint32_t wanted_ = nothing;
  LoopCandidates<Places> candidates_;
  Loop last_;
  KeptKeyframes<Places, Points> kept_;
  LoopFinder<Places, MaxFeatures> finder_;
  std::conditional_t<finds_frames, FrameLocalizer<Places>, NoFrameLocalizer> frames_;
  std::conditional_t<has_points, LocalAdjustment<Places>, NoAdjustment> adjustment_;
  MapLocalizer<Places> localizer_;
  GraphSolution<Places> solution_;
};

}  // namespace plumbline
