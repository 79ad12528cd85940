#pragma once
/// Pose graph: keyframes in order of sequence, odometry between neighbors, loop closures.  docs/math/pose_graph.md
///
///   cost = 1/2 sum |L_k r_k(T_(k-1), T_k)|^2 + 1/2 sum rho(|L_l r_l(T_i, T_j)|^2)                           (13)
/// The first node is fixed. The kind of residual is the mode: RelativePoseResidual (SE(3); RGB-D),
/// RelativePoseYawResidual (heading and position; with an IMU), RelativeSim3Residual (a camera alone). The graph holds
/// values only; map/pose_graph_solver.hpp solves it. What is not finite, or no covariance, is refused at insertion.

#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/assert.hpp"
#include "plumbline/core/result.hpp"
#include "plumbline/map/pose_graph_edge.hpp"

namespace plumbline {

enum class PoseGraphInsertion : std::uint8_t {
  inserted,
  full,                   ///< no room: nothing stored
  no_such_node,           ///< odometry before the first node, or a loop between nodes that are not two of the graph's
  not_finite,             ///< NaN or infinity in a pose, a measurement or a covariance
  not_positive_definite,  ///< the covariance has no inverse
};

template <RelativeResidual ResidualT, int MaxNodes, int MaxLoops>
class PoseGraph {
  static_assert(MaxNodes >= 2 && MaxNodes < 32768 && MaxLoops >= 1, "plumbline: a pose graph has two nodes or more");

 public:
  using Residual = ResidualT;
  using Scalar = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  static constexpr int dim = Residual::dim, max_nodes = MaxNodes, max_loops = MaxLoops;
  using Edge = PoseGraphEdge<Residual>;
  using Covariance = typename Edge::Covariance;

  struct Loop {
    int i, j;  ///< nodes; the measurement is that of T_i_j
    Edge edge;
  };

  int nodes() const { return nodes_; }
  int loops() const { return loops_; }
  void clear() { nodes_ = loops_ = 0; }

  /// The first node, whose pose does not change.
  [[nodiscard]] PoseGraphInsertion add_first(const Pose& T_map_node) {
    if (!T_map_node.is_finite()) return PoseGraphInsertion::not_finite;
    clear();
    poses_[0] = T_map_node;
    nodes_ = 1;
    return PoseGraphInsertion::inserted;
  }
  /// The next node. The odometry measured its pose in the node before, with the covariance of its right increment.
  [[nodiscard]] PoseGraphInsertion add_node(const Pose& T_map_node, const Pose& T_before_node,
                                            const Covariance& covariance) {
    if (nodes_ == 0) return PoseGraphInsertion::no_such_node;
    if (nodes_ == MaxNodes) return PoseGraphInsertion::full;
    if (!T_map_node.is_finite()) return PoseGraphInsertion::not_finite;
    const PoseGraphInsertion answer = make_edge(T_before_node, covariance, odometry_[std::size_t(nodes_)]);
    if (answer != PoseGraphInsertion::inserted) return answer;
    poses_[std::size_t(nodes_++)] = T_map_node;
    return PoseGraphInsertion::inserted;
  }
  /// The same, where the pose of the new node is that of the odometry.
  [[nodiscard]] PoseGraphInsertion add_node(const Pose& T_before_node, const Covariance& covariance) {
    if (nodes_ == 0) return PoseGraphInsertion::no_such_node;
    return add_node(pose(nodes_ - 1) * T_before_node, T_before_node, covariance);
  }
  /// A loop closure measured the pose of node j in node i. Its index is loops() - 1.
  [[nodiscard]] PoseGraphInsertion add_loop(int i, int j, const Pose& T_i_j, const Covariance& covariance) {
    if (i < 0 || j < 0 || i >= nodes_ || j >= nodes_ || i == j) return PoseGraphInsertion::no_such_node;
    if (loops_ == MaxLoops) return PoseGraphInsertion::full;
    Loop& loop = loop_edges_[std::size_t(loops_)];
    const PoseGraphInsertion answer = make_edge(T_i_j, covariance, loop.edge);
    if (answer != PoseGraphInsertion::inserted) return answer;
    loop.i = i;
    loop.j = j;
    ++loops_;
    return PoseGraphInsertion::inserted;
  }
  /// Removes loop l; the last one takes its index.
  void remove_loop(int l) {
    PLUMBLINE_ASSERT(l >= 0 && l < loops_);
    loop_edges_[std::size_t(l)] = loop_edges_[std::size_t(--loops_)];
  }

  /// T_map_node
  const Pose& pose(int node) const {
    PLUMBLINE_ASSERT(node >= 0 && node < nodes_);
    return poses_[std::size_t(node)];
  }
  /// The edge from node - 1 to node, node >= 1.
  const Edge& odometry(int node) const {
    PLUMBLINE_ASSERT(node >= 1 && node < nodes_);
    return odometry_[std::size_t(node)];
  }
  const Loop& loop(int l) const {
    PLUMBLINE_ASSERT(l >= 0 && l < loops_);
    return loop_edges_[std::size_t(l)];
  }

  /// The first `count` poses become those of `pose_of(node)`. Later nodes, inserted since these were solved for, move
  /// with the last one of them.
  template <class PoseOf>
  void set_poses(int count, PoseOf&& pose_of) {
    PLUMBLINE_ASSERT(count >= 1 && count <= nodes_);
    const Pose correction = pose_of(count - 1) * pose(count - 1).inverse();
    for (int k = 0; k < count; ++k) poses_[std::size_t(k)] = pose_of(k);
    for (int k = count; k < nodes_; ++k) poses_[std::size_t(k)] = correction * poses_[std::size_t(k)];
  }

 private:
  static PoseGraphInsertion make_edge(const Pose& measured, const Covariance& covariance, Edge& edge) {
    const Result<Edge> made = Edge::make(measured, covariance);
    if (!made) {
      return made.error() == Error::not_finite ? PoseGraphInsertion::not_finite
                                               : PoseGraphInsertion::not_positive_definite;
    }
    edge = *made;
    return PoseGraphInsertion::inserted;
  }

  int nodes_ = 0, loops_ = 0;
  std::array<Pose, std::size_t(MaxNodes)> poses_;
  std::array<Edge, std::size_t(MaxNodes)> odometry_;  ///< [k] from node k - 1 to k
  std::array<Loop, std::size_t(MaxLoops)> loop_edges_;
};

}  // namespace plumbline
