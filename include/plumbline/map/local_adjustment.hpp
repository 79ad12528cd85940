#pragma once
/// Local bundle adjustment of the keyframes that share points with the newest retired one.       docs/math/map.md 5
///
/// Free are the keyframes that share the most points with it, fixed are others that see the points of the free ones.
/// Keyframes of the window take no part: the window owns their poses, and they move with the newest retired keyframe.
/// What the window has measured is in the odometry between neighbors and in the ranges; the other observations of its
/// tracks would count it twice. New are the points that were found again.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/local_bundle_adjustment.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/point_set.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

struct NeighborhoodOptions {
  int free_keyframes = 10;        ///< at most: as many as the window has
  int min_shared_points = 15;     ///< of a free keyframe
  int min_fixed_points = 10;      ///< of a fixed keyframe
  double sigma_log_scale = 2e-3;  ///< from keyframe to keyframe, PlaceGraphOptions
  LocalBundleAdjustmentOptions solver;
};

/// Of maps whose poses loops alone correct.
struct NoAdjustment {
  explicit NoAdjustment(const NeighborhoodOptions&) {}
};

template <class Places>
class LocalAdjustment {
 public:
  using S = typename Places::S;
  using Pose = typename Places::Pose;
  using Keyframe = typename Places::Keyframe;
  static constexpr int max_keyframes = Places::max_keyframes < 24 ? Places::max_keyframes : 24;
  static constexpr std::size_t max_points = std::size_t(max_keyframes) * Places::max_features / 2;
  static constexpr std::size_t max_observations = std::size_t(max_keyframes) * Places::max_features;

  explicit LocalAdjustment(const NeighborhoodOptions& options) : options_(options), solver_(options.solver) {}

  /// Takes in the neighborhood of keyframe k, the newest that has retired. False where nothing is to be adjusted.
  bool begin(const Places& places, int k) {
    keyframes_.clear();
    choose(places, k);
    if (free_ == 0 || fixed_ < (Places::has_scale ? 2 : 1)) return false;
    if (!fill(places, k)) return false;
    solver_.begin();
    return true;
  }
  /// A slice of the solution; true when it is done.
  bool iterate(int budget) { return solver_.iterate(budget); }

  /// Poses and ranges of what is still there.
  void apply(Places& places) {
    if (!(solver_.cost() < solver_.initial_cost())) return;
    adjusted_.fill(Places::none);
    int newest = Places::none;
    for (std::size_t n = 0; n < keyframes_.size(); ++n) {
      const int k = places.find(keyframes_[n].id);
      if (k == Places::none) continue;
      adjusted_[std::size_t(k)] = int(n);
      newest = std::max(newest, k);
      if (keyframes_[n].is_fixed) {
        poses_[n] = places.graph().pose(k);
      } else {
        take(places.keyframe(k), n);
      }
      if (!poses_[n].is_finite()) return;
    }
    if (newest == Places::none) return;
    places.adjust(
        newest + 1, [this](int k) { return adjusted_[std::size_t(k)] != Places::none; },
        [this](int k) { return poses_[std::size_t(adjusted_[std::size_t(k)])]; });
  }

 private:
  static constexpr std::size_t N = std::size_t(max_keyframes);
  struct Member {
    std::uint32_t id;
    bool is_fixed;
    S scale;  ///< of its pose in the map
  };
  struct Neighbor {
    int k, shared;
  };

  void choose(const Places& places, int newest) {
    near_.clear();
    near_.add(places.keyframe(newest));
    near_.sort();
    free_ = fixed_ = 0;
    const auto is_free = [&](int k) {
      return k == newest || std::find(chosen_.begin(), chosen_.end(), k) != chosen_.end();
    };
    chosen_.clear();
    collect(places, near_, options_.min_shared_points, [&](int k) { return k != newest; });
    for (std::size_t n = 0; n < neighbors_.size() && int(n) + 1 < options_.free_keyframes; ++n)
      chosen_.push_back(neighbors_[n].k);
    points_.clear();
    points_.add(places.keyframe(newest));
    for (const int k : chosen_) points_.add(places.keyframe(k));
    points_.sort();
    collect(places, points_, options_.min_fixed_points, [&](int k) { return !is_free(k); });
    chosen_.push_back(newest);
    std::sort(chosen_.begin(), chosen_.end());
    // What nothing else holds, its oldest keyframes hold.
    const int missing = (Places::has_scale ? 2 : 1) - int(neighbors_.size());
    for (std::size_t n = 0; n < chosen_.size(); ++n) {
      const bool is_fixed = int(n) < missing || chosen_[n] == 0;
      add(places, chosen_[n], is_fixed);
    }
    for (const Neighbor& neighbor : neighbors_) {
      if (keyframes_.full()) break;
      add(places, neighbor.k, true);
    }
  }
  void add(const Places& places, int k, bool is_fixed) {
    keyframes_.push_back({places.keyframe(k).id, is_fixed, Places::Poses::to_sim3(places.graph().pose(k)).scale()});
    ++(is_fixed ? fixed_ : free_);
  }
  /// Retired keyframes that see at least so many of the points, those with the most first.
  template <std::size_t M, class May>
  void collect(const Places& places, const PointSet<M>& points, int least, May&& may) {
    neighbors_.clear();
    for (int k = 0; k < places.size(); ++k) {
      if (!places.keyframe(k).is_retired || !may(k)) continue;
      const int shared = points.count_seen(places.keyframe(k));
      if (shared >= least) neighbors_.push_back({k, shared});
    }
    std::sort(neighbors_.begin(), neighbors_.end(), [](const Neighbor& a, const Neighbor& b) {
      return a.shared > b.shared || (a.shared == b.shared && a.k > b.k);
    });
  }

  static SE3<S> camera_in_map(const Sim3<S>& S_map_body, const Keyframe& keyframe) {
    return {S_map_body.rotation() * keyframe.T_body_cam.rotation(), S_map_body * keyframe.T_body_cam.p()};
  }
  /// False where no point was found again: the window knows all that there is.
  bool fill(const Places& places, int newest) {
    solver_.clear();
    T_map_local_ = camera_in_map(Places::Poses::to_sim3(places.graph().pose(newest)), places.keyframe(newest));
    const SE3<S> T_local_map = T_map_local_.inverse();
    int oldest = newest;
    for (const Member& member : keyframes_) oldest = std::min(oldest, places.find(member.id));
    sigma_log_scale_ = Places::has_scale ? S(options_.sigma_log_scale) * std::sqrt(S(newest - oldest)) : S(0);
    starts_.clear();
    for (std::size_t n = 0; n < points_.size(); ++n) starts_.push_back({});
    for (const Member& member : keyframes_) {
      const int k = places.find(member.id);
      const Keyframe& keyframe = places.keyframe(k);
      const SE3<S> T_local_cam = T_local_map * camera_in_map(Places::Poses::to_sim3(places.graph().pose(k)), keyframe);
      (void)solver_.add_keyframe(T_local_cam, member.is_fixed);
      for (const PlaceFeature& feature : keyframe.features) {
        Start* const start = start_of(feature);
        if (!start) continue;
        start->is_recalled |= feature.is_recalled;
        if (!feature.is_located() || !(feature.sigma_range < start->relative_sigma * feature.range)) continue;
        start->best = &feature;
        start->relative_sigma = feature.sigma_range / feature.range;
        start->p = T_local_cam * Vec<S, 3>(member.scale * S(feature.range) * cast_to<S>(feature.bearing));
      }
    }
    bool is_new = false;
    for (Start& start : starts_) {
      if (start.is_recalled && start.best) start.index = solver_.add_point(start.p);
      is_new |= start.index >= 0;
    }
    if (!is_new) return false;
    for (std::size_t m = 0; m < keyframes_.size(); ++m) {
      const int k = places.find(keyframes_[m].id);
      for (const PlaceFeature& feature : places.keyframe(k).features) observe(feature, m);
      for (std::size_t l = 0; l < keyframes_.size(); ++l) connect(places, l, m);
    }
    return true;
  }
  /// What the window has not used: the best located observation, with its range, and those that were found again.
  void observe(const PlaceFeature& feature, std::size_t m) {
    const Start* const start = start_of(feature);
    if (!start || start->index < 0 || (&feature != start->best && !feature.is_recalled)) return;
    const S unit = &feature == start->best ? keyframes_[m].scale : S(0);
    (void)solver_.add_observation(int(m), start->index, cast_to<S>(feature.bearing), S(feature.sigma_rad),
                                  unit * S(feature.range), unit * S(feature.sigma_range));
  }
  /// The odometry from keyframe l to m, where they follow each other.
  void connect(const Places& places, std::size_t l, std::size_t m) {
    const int k = places.find(keyframes_[m].id);
    const Keyframe& keyframe = places.keyframe(k);
    if (k == 0 || places.keyframe(k - 1).id != keyframes_[l].id || places.keyframe(k - 1).world != keyframe.world)
      return;
    const SE3<S>& T_body_cam = keyframe.T_body_cam;
    const SE3<S> T = T_body_cam.inverse() * keyframe.T_before * T_body_cam;
    const S s = keyframes_[l].scale;
    Mat<S, 6, 6> Q = transported(keyframe.Q, SE3<S>(), T_body_cam);
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) Q(i, j) *= (i < 3 ? S(1) : s) * (j < 3 ? S(1) : s);
    }
    const Vec<S, 3> t = sigma_log_scale_ * s * (T.rotation().inverse() * T.p());
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) Q(3 + i, 3 + j) += t[i] * t[j];
    }
    (void)solver_.add_edge(int(l), int(m), SE3<S>(T.rotation(), s * T.p()), Q);
  }

  /// The pose of a free keyframe, whose unit stays: loops alone tell it. The ranges of its features follow.
  void take(Keyframe& keyframe, std::size_t n) {
    const SE3<S> T_map_cam = T_map_local_ * solver_.pose(int(n)), T_cam_local = solver_.pose(int(n)).inverse();
    const S scale = keyframes_[n].scale;
    const SO3<S> R = T_map_cam.rotation() * keyframe.T_body_cam.rotation().inverse();
    poses_[n] = Places::Poses::from_sim3(Sim3<S>(scale, R, T_map_cam.p() - scale * (R * keyframe.T_body_cam.p())));
    for (PlaceFeature& feature : keyframe.features) {
      const Start* const start = start_of(feature);
      if (!start || start->index < 0 || !feature.is_located()) continue;
      const Vec<S, 3> p = T_cam_local * solver_.point(start->index);
      const float range = float(norm(p) / scale);
      if (!(p.z() > S(0)) || !std::isfinite(range)) continue;
      feature.sigma_range *= range / feature.range;
      feature.range = range;
    }
  }

  struct Start {
    Vec<S, 3> p = zeros<S, 3>();
    const PlaceFeature* best = nullptr;  ///< the feature that knows its range best
    float relative_sigma = 1;
    int index = -1;            ///< in the solver
    bool is_recalled = false;  ///< it was found again
  };
  /// nullptr of what is no point of the neighborhood.
  Start* start_of(const PlaceFeature& feature) {
    const int n = feature.point == PlaceFeature::no_point ? -1 : points_.find(feature.point);
    return n < 0 ? nullptr : &starts_[std::size_t(n)];
  }

  NeighborhoodOptions options_;
  int free_ = 0, fixed_ = 0;
  SE3<S> T_map_local_;
  S sigma_log_scale_ = S(0);  ///< between the units of the oldest and the newest keyframe
  FixedVector<Member, N> keyframes_;
  FixedVector<int, N> chosen_;
  FixedVector<Neighbor, std::size_t(Places::max_keyframes)> neighbors_;
  PointSet<Places::max_features> near_;
  PointSet<max_points> points_;
  FixedVector<Start, max_points> starts_;
  std::array<int, std::size_t(Places::max_keyframes)> adjusted_;
  std::array<Pose, N> poses_;
  LocalBundleAdjustment<S, max_keyframes, int(max_points), int(max_observations), 1, max_keyframes> solver_;
};

}  // namespace plumbline
