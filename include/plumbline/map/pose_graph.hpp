#pragma once
/// Pose graph: keyframes in order of sequence, odometry between neighbors, loop closures.  docs/math/pose_graph.md
///
///   cost = 1/2 sum |L_k r_k(T_(k-1), T_k)|^2 + 1/2 sum rho(|L_l r_l(T_i, T_j)|^2)                           (13)
/// The first node is fixed. The kind of residual is the mode: RelativePoseResidual (SE(3); RGB-D),
/// RelativePoseYawResidual (heading and position; with an IMU), RelativeSim3Residual (a camera alone). The graph holds
/// values only; map/pose_graph_solver.hpp solves it. What is not finite, or no covariance, is refused at insertion.

#include <algorithm>
#include <array>
#include <cmath>
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
  /// Replaces what the odometry measured between node - 1 and node, node >= 1. Poses stay.
  [[nodiscard]] PoseGraphInsertion set_odometry(int node, const Pose& T_before_node, const Covariance& covariance) {
    if (node < 1 || node >= nodes_) return PoseGraphInsertion::no_such_node;
    return make_edge(T_before_node, covariance, odometry_[std::size_t(node)]);
  }
  /// Removes any node but the only one; later nodes take the index before theirs, poses stay. Its two odometry edges
  /// become one by composition; of the first or the last node, the one edge is dropped. Its loops move to the neighbor
  /// with the more certain odometry edge (by the determinant), or to the other one where that is their other end, by
  /// composition with this edge. A loop without a neighbor to move to is removed, see remove_loop. False, and nothing
  /// changed, where there is no such node or the composed odometry is no edge (numbers that overflow).
  [[nodiscard]] bool remove_node(int node) {
    if (node < 0 || node >= nodes_ || nodes_ < 2) return false;
    const bool before = node > 0, after = node + 1 < nodes_;
    Edge merged;
    if (before && after) {
      const Result<Edge> composed = odometry(node).composed(pose(node - 1), odometry(node + 1));
      if (!composed) return false;
      merged = *composed;
    }
    const bool to_before = before && (!after || log_information(node) >= log_information(node + 1));
    for (int l = loops_ - 1; l >= 0; --l) {
      Loop& loop = loop_edges_[std::size_t(l)];
      if (loop.i != node && loop.j != node) continue;
      const int other = loop.i == node ? loop.j : loop.i;
      int neighbor = to_before ? node - 1 : node + 1;
      if (neighbor == other) neighbor = 2 * node - neighbor;
      if (neighbor < 0 || neighbor >= nodes_ || !move_loop(loop, node, neighbor)) remove_loop(l);
    }
    for (int l = 0; l < loops_; ++l) {
      Loop& loop = loop_edges_[std::size_t(l)];
      loop.i -= loop.i > node;
      loop.j -= loop.j > node;
    }
    if (before && after) odometry_[std::size_t(node + 1)] = merged;
    std::copy(poses_.begin() + node + 1, poses_.begin() + nodes_, poses_.begin() + node);
    std::copy(odometry_.begin() + node + 1, odometry_.begin() + nodes_, odometry_.begin() + node);
    --nodes_;
    return true;
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
  /// Half the logarithm of the determinant of an odometry edge's information.
  Scalar log_information(int node) const {
    Scalar sum = Scalar(0);
    for (int k = 0; k < dim; ++k) sum += std::log(odometry(node).L(k, k));
    return sum;
  }
  /// The end of a loop at `node` moves to its neighbor. False, and nothing changed, where the result is no edge.
  bool move_loop(Loop& loop, int node, int neighbor) const {
    const bool is_j = loop.j == node;
    const int from = is_j ? node : neighbor, to = is_j ? neighbor : node;  // the step to compose with
    const Edge& edge = odometry(std::max(from, to));
    const Result<Edge> step = from < to ? Result<Edge>(edge) : edge.inverse(pose(to));
    if (!step) return false;
    const Result<Edge> moved = is_j ? loop.edge.composed(pose(loop.i), *step) : step->composed(pose(from), loop.edge);
    if (!moved) return false;
    loop.edge = *moved;
    (is_j ? loop.j : loop.i) = neighbor;
    return true;
  }
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
