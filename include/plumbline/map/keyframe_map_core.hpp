#pragma once
/// What a map of keyframes does with them, whoever describes their features.                       docs/math/map.md
///
/// learn:    descriptors of a new keyframe, ranges of its landmarks; node and edge of the pose graph (place_graph.hpp)
/// query:    the retired keyframes that look most like the newest one (hamming_place_index.hpp)
/// verify:   pose in the older keyframe (place_pose.hpp); chi-square test against the odometry (loop_gate.hpp), and
///           against gravity; two keyframes in a row agree
/// solve:    pose graph (pose_graph_solver.hpp): heading and position with an IMU, SE(3) with depth, else Sim(3)
/// Frames without a pose of their own are found in the map one by one (frame_localizer.hpp), of rigs without an IMU.
/// A map may be saved and taken in by another run (place_archive.hpp), which extends it, or only finds itself in it
/// (map_localizer.hpp). Query, each candidate, and slices of the solution are done one a frame, chosen by counts: the
/// same input gives the same output.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <utility>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/found_frame.hpp"
#include "plumbline/map/frame_localizer.hpp"
#include "plumbline/map/hamming_place_index.hpp"
#include "plumbline/map/keyframe_map_counts.hpp"
#include "plumbline/map/keyframe_map_options.hpp"
#include "plumbline/map/local_adjustment.hpp"
#include "plumbline/map/loop_finder.hpp"
#include "plumbline/map/map_correction.hpp"
#include "plumbline/map/map_localizer.hpp"
#include "plumbline/map/map_points.hpp"
#include "plumbline/map/place_archive.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/pose_graph_solver.hpp"
#include "plumbline/map/world_change.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

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
  using Points = std::conditional_t<has_points, MapPoints<Places, MaxPoints>, NoMapPoints>;

  explicit KeyframeMapCore(const KeyframeMapOptions& options)
      : options_(options),
        places_(options.graph),
        finder_(options),
        frames_(options.frames),
        adjustment_(options.neighborhood) {}

  const Places& places() const { return places_; }
  const KeyframeMapCounts& counts() const { return counts_; }
  /// Correction of the present world; counts().corrections tells how often it has changed.
  Sim3<S> S_map_world() const { return places_.S_map_world(); }
  /// Covariance of the newest keyframe's pose in the map, see map_correction.hpp; false where it is not known.
  bool covariance_in_map(Covariance& out) const {
    return places_.size() > 0 && correction_.covariance(places_, places_.size() - 1, out);
  }

  /// sink(std::span<const std::byte>) gets the bytes of the map, place_archive.hpp. In any state.
  template <class Sink>
  void save(Sink&& sink) const {
    save_places(places_, sink, loaded_ > 0 ? places_.keyframe(0).world : largest_world(places_));
  }
  /// Takes a saved map in, before the first frame. On an error nothing has changed.
  MapArchiveError load(std::span<const std::byte> bytes) {
    const int room = MaxKeyframes - (options_.localize_only ? run_keyframes : 0);
    const MapArchiveError error = load_places(bytes, places_, room);
    if (error != MapArchiveError::none) return error;
    loaded_ = places_.size();
    for (int k = 0; k < loaded_; ++k) index_.add(std::uint32_t(places_.slot(k)), descriptors_of(places_.keyframe(k)));
    if (loaded_ > 0) first_id_ = places_.keyframe(loaded_ - 1).id;
    return error;
  }
  /// Keyframes that were taken in, before those of this run.
  int loaded() const { return loaded_; }
  /// Whether the present world has its place in the map that was taken in; true without one.
  bool is_in_map() const {
    return loaded_ == 0 || is_frame_found_ || localizer_.is_localized() || is_connected(places_.world());
  }

  void set_pose(std::uint32_t id, const SE3<S>& T_world_body) { places_.set_pose(first_id_ + id, T_world_body); }
  void set_covariance(std::uint32_t a, std::uint32_t b, const Mat<S, 6, 6>& covariance) {
    places_.set_covariance(first_id_ + a, first_id_ + b, covariance);
  }
  /// A new keyframe, to be given its features; nullptr when it is refused. `finish` ends it.
  Keyframe* begin_keyframe(std::uint32_t id, TimeNs t_ns, const SE3<S>& T_world_body, const SE3<S>& T_body_cam,
                           const Mat<S, 6, 6>& covariance) {
    if (options_.localize_only && places_.size() - loaded_ >= run_keyframes) forget_oldest();
    if (places_.size() == MaxKeyframes) evict();
    if (!places_.add(first_id_ + id, t_ns, T_world_body, T_body_cam, covariance)) return nullptr;
    return &places_.keyframe(places_.size() - 1);
  }
  void finish_keyframe() {
    const int k = places_.size() - 1;
    index_.remove(std::uint32_t(places_.slot(k)));
    index_.add(std::uint32_t(places_.slot(k)), descriptors_of(places_.keyframe(k)));
    if (stage_ == Stage::query) wanted_ = places_.keyframe(k).id;
  }
  Keyframe* retire(std::uint32_t id, const SE3<S>& T_world_body) {
    places_.retire(first_id_ + id, T_world_body);
    const int k = places_.find(first_id_ + id);
    if (k == none) return nullptr;
    is_unadjusted_ = true;
    return &places_.keyframe(k);
  }
  void change_world(const WorldChange<S>& change) {
    using Kind = typename WorldChange<S>::Kind;
    abandon();
    switch (change.kind) {
      case Kind::transformed:
        places_.transform(change.S_new_old, change.T_body_cam);
        finder_.forget_aliases();
        correction_.forget();
        is_initialized_ = true;
        break;
      case Kind::rejected: remove_present_world(); break;
      case Kind::reset:
        if (Places::has_gravity && !is_initialized_) remove_present_world();  // its axes and unit are not the map's
        places_.begin_world();
        is_initialized_ = false;
        break;
    }
  }

  /// What work() does next.
  Stage stage() const { return stage_; }
  /// One slice: a query, a candidate, or a part of the solution.
  void work() {
    is_frame_found_ = false;
    switch (stage_) {
      case Stage::query: return query();
      case Stage::verify: return verify();
      case Stage::solve: return solve();
      case Stage::adjust: return adjust();
    }
  }

 protected:
  static constexpr bool finds_frames = !Places::has_gravity;

  auto& begin_frame() { return frames_.begin_frame(); }
  /// The pose of the frame that was given its features.
  template <class View>
  bool find_frame(const View& view, const SO3<S>& R_cur_prev, FoundFrame<S>& found) {
    if (stage_ == Stage::query) places_.update();
    bool is_ambiguous = false;
    const auto* const pose = frames_.find(
        view, R_cur_prev, places_, index_, options_.pose, options_.common_range_error, options_.min_alias,
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
  Places& mutable_places() { return places_; }
  Points& points() { return points_; }
  void count_recalled(std::size_t points) { counts_.recalled += int(points); }

 private:
  using Loop = PlaceLoop<Places>;
  static constexpr std::uint32_t nothing = Loop::nothing;
  static constexpr std::size_t candidates = 3;
  /// Of this run where the map is only read: more than a window, and not more than half of what there is room for.
  static constexpr int run_keyframes = std::min(40, MaxKeyframes / 2);
  using Graph = typename Places::Graph;

  std::span<const BinaryDescriptor> descriptors_of(const Keyframe& keyframe) {
    descriptors_.clear();
    for (const PlaceFeature& feature : keyframe.features) descriptors_.push_back(feature.descriptor);
    return {descriptors_.data(), descriptors_.size()};
  }
  void remove_present_world() {
    correction_.forget();
    for (int k = places_.size() - 1; k >= 0 && places_.keyframe(k).world == places_.world(); --k) {
      index_.remove(std::uint32_t(places_.slot(k)));
      points_.forget(places_.keyframe(k), places_.slot(k));
    }
    places_.remove_present_world();
  }
  /// Ends what is going on: keyframes change.
  void abandon() {
    stage_ = Stage::query;
    wanted_ = nothing;
    localizer_.reset();
    last_ = {};
  }
  /// Removes the oldest retired keyframe of this run.
  void forget_oldest() {
    int k = loaded_;
    while (k < places_.size() && !places_.keyframe(k).is_retired) ++k;
    if (k == places_.size()) return;
    remove(k);
  }
  void evict() {
    if (options_.localize_only) return;
    const int k = places_.most_redundant();
    if (k == none) return;
    if (stage_ == Stage::solve) is_unsolved_ = true;
    stage_ = Stage::query;
    counts_.evicted += remove(k);
  }
  bool remove(int k) {
    const int slot = places_.slot(k);
    correction_.before_removal(places_, k);
    if (!places_.remove(k)) return false;
    index_.remove(std::uint32_t(slot));
    points_.forget(places_.keyframe_in(slot), slot);
    return true;
  }

  /// A map that is only read is not found by keyframes of this run.
  bool can_be_recognized(const Keyframe& keyframe) const {
    return keyframe.is_retired && (!options_.localize_only || keyframe.id <= first_id_);
  }
  void query() {
    if (std::exchange(is_unsolved_, false) && places_.graph().loops() > 0) return begin_solution();
    const int j = wanted_ == nothing ? none : places_.find(std::exchange(wanted_, nothing));
    if (j == none || (Places::has_gravity && !is_initialized_)) return begin_adjustment();
    if (last_.is_inserted && places_.find(last_.j) != none && j - places_.find(last_.j) < options_.loop_spacing) return;
    places_.update();
    const Keyframe& current = places_.keyframe(j);
    found_ = index_.query(descriptors_of(current), candidates_,
                          [this](std::uint32_t slot) { return can_be_recognized(places_.in_slot(int(slot))); });
    while (found_ > 0 && candidates_[found_ - 1].score < options_.min_score) --found_;
    ++counts_.queries;
    next_ = 0;
    asked_ = current.id;
    if (found_ > 0) stage_ = Stage::verify;
  }

  void verify() {
    const int j = places_.find(asked_);
    if (j == none || next_ == found_) return end_query();
    const PlaceCandidate candidate = candidates_[next_++];
    int i = none;
    for (int k = 0; k < j; ++k) {
      if (places_.slot(k) == int(candidate.id)) i = k;
    }
    if (i == none) return;
    Loop loop;
    if (!finder_.find(places_, i, j, loop, counts_)) return;
    ++counts_.verified;
    const bool has_agreed = finder_.agrees(places_, last_, loop);
    if (has_agreed && !options_.localize_only) points_.join(places_, i, j, finder_.matches());
    if (options_.localize_only) return localize(loop, has_agreed);
    if (has_agreed && (last_.is_inserted || insert(last_)) && insert(loop)) {
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
    if (has_agreed && localizer_.add(places_, loop, options_.gate)) {
      places_.join(places_.find(loop.j), localizer_.pose());
      ++counts_.loops;
      ++counts_.corrections;
      correction_.set(loop.j, localizer_.covariance(), true);
      counts_.relocalizations += !was_localized;
    }
    last_ = loop;
    end_query();
  }

  bool insert(const Loop& loop) {
    const int i = places_.find(loop.i), j = places_.find(loop.j);
    if (i == none || j == none) return false;
    Graph& graph = places_.graph();
    if (graph.loops() == Graph::max_loops) graph.remove_loop(most_crowded_loop());
    if (places_.keyframe(i).world != places_.keyframe(j).world && !is_connected(places_.keyframe(j).world)) {
      places_.join(j, graph.pose(i) * loop.T_i_j);  // the solution would begin far from where it ends
      ++counts_.relocalizations;
    }
    if (graph.add_loop(i, j, loop.T_i_j, loop.covariance) != PoseGraphInsertion::inserted) return false;
    ++counts_.loops;
    return true;
  }
  /// Whether a loop connects that world with an earlier one.
  bool is_connected(std::uint32_t world) const {
    const Graph& graph = places_.graph();
    for (int l = 0; l < graph.loops(); ++l) {
      const std::uint32_t a = places_.keyframe(graph.loop(l).i).world, b = places_.keyframe(graph.loop(l).j).world;
      if (a != b && (a == world || b == world)) return true;
    }
    return false;
  }
  /// The loop whose later end is nearest to that of another one.
  int most_crowded_loop() const {
    const Graph& graph = places_.graph();
    int best = 0, least = MaxKeyframes;
    for (int l = 0; l < graph.loops(); ++l) {
      int nearest = MaxKeyframes;
      for (int m = 0; m < graph.loops(); ++m) {
        if (m != l) nearest = std::min(nearest, std::abs(graph.loop(l).j - graph.loop(m).j));
      }
      if (nearest >= least) continue;
      least = nearest;
      best = l;
    }
    return best;
  }

  void begin_solution() {
    places_.update();
    solver_.begin(places_.graph());
    T_world_newest_ = places_.keyframe(places_.size() - 1).T_world_body;
    world_newest_ = places_.world();
    stage_ = Stage::solve;
  }
  void begin_adjustment() {
    if constexpr (has_points) {
      if (options_.localize_only || !std::exchange(is_unadjusted_, false)) return;
      int k = places_.size() - 1;
      while (k >= 0 && !places_.keyframe(k).is_retired) --k;
      if (k < 0 || places_.keyframe(k).world != places_.world()) return;
      places_.update();
      if (adjustment_.begin(places_, k)) stage_ = Stage::adjust;
    }
  }
  void adjust() {
    if constexpr (has_points) {
      if (!adjustment_.iterate(options_.adjustment_budget)) return;
      stage_ = Stage::query;
      adjustment_.apply(places_);
      ++counts_.adjustments;
    }
  }
  void solve() {
    if (!solver_.iterate(options_.solver_budget)) return;
    stage_ = Stage::query;
    const int n = solver_.nodes();
    for (int k = 0; k < n; ++k) {
      if (!solver_.pose(k).is_finite()) return;
    }
    if (world_newest_ != places_.world()) return;
    places_.correct(
        n, [this](int k) { return solver_.pose(k); }, T_world_newest_);
    correction_.set(places_.keyframe(n - 1).id, cast_to<S>(solver_.newest_covariance()), solver_.covariance_valid());
    ++counts_.corrections;
  }

  KeyframeMapOptions options_;
  KeyframeMapCounts counts_;
  Stage stage_ = Stage::query;
  bool is_initialized_ = false, is_unsolved_ = false, is_unadjusted_ = false, is_frame_found_ = false;
  int loaded_ = 0;              ///< keyframes of the map that was taken in
  std::uint32_t first_id_ = 0;  ///< before those of this run
  std::uint32_t wanted_ = nothing, asked_ = nothing, world_newest_ = 0;
  std::array<PlaceCandidate, candidates> candidates_;
  std::size_t found_ = 0, next_ = 0;
  Loop last_;
  SE3<S> T_world_newest_;
  FixedVector<BinaryDescriptor, MaxFeatures> descriptors_;
  Places places_;
  MapCorrection<Places> correction_;
  Points points_;
  HammingPlaceIndex<std::size_t(MaxKeyframes), MaxFeatures> index_;
  LoopFinder<Places, MaxFeatures> finder_;
  std::conditional_t<finds_frames, FrameLocalizer<Places>, NoFrameLocalizer> frames_;
  std::conditional_t<has_points, LocalAdjustment<Places>, NoAdjustment> adjustment_;
  MapLocalizer<Places> localizer_;
  PoseGraphSolver<Graph> solver_;
};

}  // namespace plumbline
