#pragma once
/// Keyframes in order of sequence with their pose graph: poses in their world, odometry between neighbors, loops, and
/// the correction of the present world.                                                       docs/math/map.md 1
///
///   S_map_world = S_map_n T_n^-1 of the newest keyframe n that was solved for                                      (7)

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/graph_poses.hpp"
#include "plumbline/map/keyframe_slots.hpp"
#include "plumbline/map/map_archive.hpp"
#include "plumbline/map/odometry_edges.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/pose_graph.hpp"
#include "plumbline/state/world_frame_uncertainty.hpp"

namespace plumbline {

struct PlaceGraphOptions {
  OdometryEdgeOptions odometry;
  double sigma_log_scale = 2e-3;  ///< of an edge without an IMU and depth: 100 ranges of 2 % each
  double unknown_log_scale = 10;  ///< of an edge to a new world
};

template <RelativeResidual ResidualT, int MaxKeyframes, std::size_t MaxFeatures, int MaxLoops>
class PlaceGraph {
 public:
  using Residual = ResidualT;
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  using Keyframe = PlaceKeyframe<S, MaxFeatures>;
  using Graph = PoseGraph<Residual, MaxKeyframes, MaxLoops>;
  using Covariance = typename Graph::Covariance;
  using Poses = GraphPoses<Residual>;
  static constexpr bool has_scale = Poses::has_scale, has_gravity = Poses::has_gravity;
  static constexpr int max_keyframes = MaxKeyframes, none = -1;
  static constexpr std::size_t max_features = MaxFeatures;

  explicit PlaceGraph(const PlaceGraphOptions& options) : options_(options), edges_(options.odometry) {}

  int size() const { return keyframes_.size(); }
  /// Of the k-th one in order of sequence.
  int slot(int k) const { return keyframes_.slot(k); }
  const Keyframe& keyframe(int k) const { return keyframes_[k]; }
  Keyframe& keyframe(int k) { return keyframes_[k]; }
  const Keyframe& in_slot(int slot) const { return keyframes_.in_slot(slot); }
  Keyframe& keyframe_in(int slot) { return keyframes_.in_slot(slot); }
  /// Place in the order of the keyframe with that id, `none` of others.
  int find(std::uint32_t id) const { return keyframes_.find(id); }
  Graph& graph() { return graph_; }
  const Graph& graph() const { return graph_; }
  const Sim3<S>& S_map_world() const { return S_map_world_; }
  std::uint32_t world() const { return world_; }

  /// A new keyframe, without features. False when there is no room or its pose is not finite.
  bool add(std::uint32_t id, TimeNs t_ns, const SE3<S>& T_world_body, const SE3<S>& T_body_cam,
           const Mat<S, 6, 6>& covariance) {
    if (keyframes_.full() || !T_world_body.is_finite() || !all_finite(covariance)) return false;
    Keyframe& added = keyframe(size());
    added.features.clear();
    added.id = id;
    added.world = world_;
    added.t_ns = t_ns;
    added.T_world_body = added.T_world_body_in_graph = T_world_body;
    added.is_moved = added.is_new = added.begins_mean = false;
    added.T_body_cam = T_body_cam;
    added.covariance = covariance;
    added.is_retired = false;
    added.is_fixed = added.is_known = false;
    if (size() == 0) {
      if (graph_.add_first(in_map(T_world_body)) != PoseGraphInsertion::inserted) return false;
    } else {
      edges_.measure(in_order(), size());
      if (graph_.add_node(in_map(T_world_body), Poses::to_pose(added.T_before), of_edge(size())) !=
          PoseGraphInsertion::inserted)
        return false;
    }
    keyframes_.append();
    edges_.carry_back(in_order(), size() - 1);
    return true;
  }
  /// A keyframe of a saved map, after those before it; its features are to follow. False where its numbers are no pose.
  bool restore(const ArchivedKeyframe& archived) {
    if (keyframes_.full()) return false;
    Keyframe& restored = keyframe(size());
    restored.features.clear();
    restored.id = archived.id;
    restored.world = archived.world;
    restored.t_ns = archived.t_ns;
    restored.T_world_body = restored.T_world_body_in_graph = archived.T_world_body.template cast<S>();
    restored.T_body_cam = archived.T_body_cam.template cast<S>();
    restored.T_before = archived.T_before.template cast<S>();
    restored.Q = cast_to<S>(archived.Q);
    set_zero(restored.covariance);
    restored.is_moved = restored.is_new = false;
    restored.begins_mean = restored.is_retired = restored.is_fixed = true;
    const Pose T_map_body = Poses::from_sim3(archived.S_map_body.template cast<S>());
    const bool follows = size() > 0 && keyframe(size() - 1).world == restored.world;
    const PoseGraphInsertion answer =
        size() == 0 ? graph_.add_first(T_map_body)
                    : graph_.add_node(T_map_body, Poses::to_pose(restored.T_before),
                                      Poses::of_increment(restored.Q, T_map_body, sigma_log_scale(follows)));
    if (answer != PoseGraphInsertion::inserted) return false;
    keyframes_.append();
    world_ = archived.world + 1;
    return true;
  }
  void clear() {
    keyframes_.clear();
    world_ = 0;
    graph_.clear();
  }
  /// The window has moved a frame.
  void set_pose(std::uint32_t id, const SE3<S>& T_world_body) {
    const int k = find(id);
    if (k == none || keyframe(k).is_retired || !T_world_body.is_finite()) return;
    keyframe(k).T_world_body = T_world_body;
    keyframe(k).is_moved = true;
  }
  /// The window knows the covariance of the pose of frame b in frame a. Before either retires.
  void set_covariance(std::uint32_t a, std::uint32_t b, const Mat<S, 6, 6>& covariance) {
    const int k = find(b);
    if (k <= 0 || keyframe(k).is_fixed || keyframe(k - 1).id != a || !all_finite(covariance)) return;
    keyframe(k).Q = covariance;
    keyframe(k).is_known = true;
  }
  /// A frame leaves the window: its edges are final.
  void retire(std::uint32_t id, const SE3<S>& T_world_body) {
    set_pose(id, T_world_body);
    const int k = find(id);
    if (k == none || keyframe(k).is_retired) return;
    for (int edge = k; edge <= k + 1 && edge < size(); ++edge) {
      if (edge == 0 || keyframe(edge).is_fixed) continue;
      edges_.measure(in_order(), edge);
      keyframe(edge).is_fixed = true;
      keyframe(edge).is_new = true;
    }
    keyframe(k).is_retired = true;
  }
  /// Brings the edges and poses of the pose graph up to date: what the window has moved a keyframe by since, moves it
  /// there, too. From the first loop on the first one is fixed. Not while the graph is solved.
  void update() {
    if (size() == 0) return;
    for (int k = 1; k < size(); ++k) {
      Keyframe& keyframe = this->keyframe(k);
      if (keyframe.is_fixed && !std::exchange(keyframe.is_new, false)) continue;
      if (!keyframe.is_fixed) edges_.measure(in_order(), k);
      (void)graph_.set_odometry(k, Poses::to_pose(keyframe.T_before), of_edge(k));
    }
    graph_.set_poses(size(), [this](int k) {
      Keyframe& keyframe = this->keyframe(k);
      if (!keyframe.is_moved || (k == 0 && graph_.loops() > 0)) return graph_.pose(k);
      const SE3<S> moved = keyframe.T_world_body_in_graph.inverse() * keyframe.T_world_body;
      return graph_.pose(k) * Poses::to_pose(moved);
    });
    for (int k = 0; k < size(); ++k) account_for(keyframe(k));
  }
  /// The keyframe that tells least: between whose neighbors the camera has moved least; `none` without one.
  int most_redundant() const {
    int best = none;
    S least = S(0);
    for (int k = 1; k + 1 < size(); ++k) {
      if (!keyframe(k).is_retired || !keyframe(k + 1).is_retired || keyframe(k - 1).world != keyframe(k + 1).world)
        continue;
      const SE3<S> T = keyframe(k - 1).T_world_body.inverse() * keyframe(k + 1).T_world_body;
      const S motion = norm(T.p()) / keyframe(k).mean_range() + norm(T.rotation().log());
      if (best != none && !(motion < least)) continue;
      best = k;
      least = motion;
    }
    return best;
  }
  /// Removes a keyframe; those after it move up by one. False, and nothing changed, where the pose graph cannot.
  bool remove(int k) {
    if (size() == 1) {
      graph_.clear();
    } else if (!graph_.remove_node(k)) {
      return false;
    }
    if (k > 0 && k + 1 < size()) {
      Keyframe &gone = keyframe(k), &next = keyframe(k + 1);
      const Mat<S, 6, 6> Q = transported(gone.Q, SE3<S>(), next.T_before) + next.Q;
      next.T_before = gone.T_before * next.T_before;
      next.Q = Q;
      next.is_fixed = next.is_new = true;
    }
    keyframes_.remove(k);
    return true;
  }
  /// Its keyframes with all their loops.
  void remove_present_world() {
    for (int l = graph_.loops() - 1; l >= 0; --l) {
      if (keyframe(graph_.loop(l).i).world == world_ || keyframe(graph_.loop(l).j).world == world_)
        graph_.remove_loop(l);
    }
    while (size() > 0 && keyframe(size() - 1).world == world_ && remove(size() - 1)) {
    }
  }
  void begin_world() { ++world_; }
  /// x_new = S_new_old x_old of the cameras in the present world, whose extrinsics become T_body_cam.
  void transform(const Sim3<S>& S_new_old, const SE3<S>& T_body_cam) {
    for (int k = 0; k < size(); ++k) {
      Keyframe& keyframe = this->keyframe(k);
      if (keyframe.world != world_) continue;
      keyframe.transform(S_new_old, T_body_cam);
      if (k > 0 && this->keyframe(k - 1).world == world_)
        keyframe.T_before = this->keyframe(k - 1).T_world_body.inverse() * keyframe.T_world_body;
    }
    rebuild_poses();
  }
  /// The present world is put where its keyframe k has that pose in the map.
  void join(int k, const Pose& T_map_k) {
    const SE3<S>& T_world_k = keyframe(k).T_world_body;
    S_map_world_ = Poses::to_sim3(T_map_k) * Poses::to_sim3(T_world_k).inverse();
    if constexpr (has_gravity) {  // turned about the vertical alone, about keyframe k
      const Mat<S, 3, 3> R = S_map_world_.rotation().matrix();
      const SO3<S> heading = SO3<S>::exp({S(0), S(0), std::atan2(R(1, 0) - R(0, 1), R(0, 0) + R(1, 1))});
      S_map_world_ = Sim3<S>(S(1), heading, T_map_k.p() - heading * T_world_k.p());
    }
    rebuild_poses();
  }
  /// The pose graph has been solved: poses of the first `count` keyframes; `T_world_newest` was that of the last one.
  template <class PoseOf>
  void correct(int count, PoseOf&& pose_of, const SE3<S>& T_world_newest) {
    S_map_world_ = Poses::to_sim3(pose_of(count - 1)) * Poses::to_sim3(T_world_newest).inverse();
    graph_.set_poses(count, pose_of);
  }

  /// Keyframes have been adjusted: their poses; the edges between neighbors that both take part become those of the
  /// poses. What follows the first `count`, and the present world, move with the last one of them.
  template <class IsAdjusted, class PoseOf>
  void adjust(int count, IsAdjusted&& is_adjusted, PoseOf&& pose_of) {
    graph_.set_poses(count, [&](int k) { return is_adjusted(k) ? pose_of(k) : graph_.pose(k); });
    for (int k = 1; k < count; ++k) {
      if (!keyframe(k).is_fixed || keyframe(k - 1).world != keyframe(k).world) continue;
      if (!is_adjusted(k - 1) || !is_adjusted(k)) continue;
      keyframe(k).is_new = false;
      (void)graph_.set_odometry(k, graph_.pose(k - 1).inverse() * graph_.pose(k), of_edge(k));
    }
    if (keyframe(count - 1).world == world_)
      S_map_world_ =
          Poses::to_sim3(graph_.pose(count - 1)) * Poses::to_sim3(keyframe(count - 1).T_world_body).inverse();
  }

  Pose in_map(const SE3<S>& T_world_body) const { return Poses::from_sim3(S_map_world_ * Sim3<S>(T_world_body)); }

 private:
  auto in_order() {
    return [this](int k) -> Keyframe& { return keyframe(k); };
  }
  Covariance of_edge(int k) const {
    const bool is_connected = keyframe(k - 1).world == keyframe(k).world;
    return Poses::of_increment(keyframe(k).Q, in_map(keyframe(k).T_world_body), sigma_log_scale(is_connected));
  }
  S sigma_log_scale(bool is_connected) const {
    return S(is_connected ? options_.sigma_log_scale : options_.unknown_log_scale);
  }
  /// Poses of the present world anew, from the window.
  void rebuild_poses() {
    if (size() == 0) return;
    const auto pose_of = [this](int k) {
      return keyframe(k).world == world_ ? in_map(keyframe(k).T_world_body) : graph_.pose(k);
    };
    graph_.set_poses(size(), pose_of);
    for (int k = 0; k < size(); ++k) account_for(keyframe(k));
  }
  static void account_for(Keyframe& keyframe) {
    keyframe.T_world_body_in_graph = keyframe.T_world_body;
    keyframe.is_moved = false;
  }
  PlaceGraphOptions options_;
  OdometryEdges<Keyframe> edges_;
  std::uint32_t world_ = 0;
  Sim3<S> S_map_world_;
  KeyframeSlots<Keyframe, MaxKeyframes> keyframes_;
  Graph graph_;
};

}  // namespace plumbline
