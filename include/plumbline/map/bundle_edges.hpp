#pragma once
/// Odometry between the keyframes of a bundle adjustment.                    docs/math/local_bundle_adjustment.md (12)
///
///   1/2 |L r(T_a, T_b)|^2,   r of residual/relative_pose.hpp; least squares, without a kernel                (12)

#include <array>
#include <concepts>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/map/bundle_keyframes.hpp"
#include "plumbline/map/pose_graph_edge.hpp"

namespace plumbline {

template <std::floating_point S, int MaxKeyframes, int MaxEdges>
class BundleEdges {
 public:
  using Keyframes = BundleKeyframes<S, MaxKeyframes>;
  using Edge = PoseGraphEdge<RelativePoseResidual<S>>;

  void clear() { count_ = 0; }
  int count() const { return count_; }
  bool add(int a, int b, const SE3<S>& T_a_b, const Mat<S, 6, 6>& covariance) {
    if (count_ == MaxEdges || a == b) return false;
    const Result<Edge> made = Edge::make(T_a_b, covariance);
    if (!made) return false;
    edge_[std::size_t(count_++)] = {a, b, *made};
    return true;
  }
  template <class Normal>
  void linearize(int edge, const Keyframes& keyframes, Normal& normal) const {
    const auto& [a, b, measured] = edge_[std::size_t(edge)];
    const SE3<S>&T_a = keyframes.state(a).T_map_cam, &T_b = keyframes.state(b).T_map_cam;
    const auto rows = measured.template linearize<double>(T_a, T_b);
    const int block_a = keyframes.block(a), block_b = keyframes.block(b);
    const Mat<double, 6, 6> J_a = in_axes_of_map(rows.J_i, T_a), J_b = in_axes_of_map(rows.J_j, T_b);
    if (block_a != Keyframes::none && block_b != Keyframes::none) {
      normal.add(block_a, J_a, block_b, J_b, rows.r, 1.0);
    } else if (block_a != Keyframes::none) {
      normal.add(block_a, J_a, rows.r, 1.0);
    } else if (block_b != Keyframes::none) {
      normal.add(block_b, J_b, rows.r, 1.0);
    }
  }
  double state_cost(int edge, const Keyframes& keyframes) const {
    const auto& [a, b, measured] = edge_[std::size_t(edge)];
    return measured.template chi2<double>(keyframes.state(a).T_map_cam, keyframes.state(b).T_map_cam) / 2;
  }
  double trial_cost(int edge, const Keyframes& keyframes) const {
    const auto& [a, b, measured] = edge_[std::size_t(edge)];
    return measured.template chi2<double>(keyframes.trial(a).T_map_cam, keyframes.trial(b).T_map_cam) / 2;
  }

 private:
  struct Between {
    int a, b;
    Edge edge;
  };
  std::array<Between, std::size_t(MaxEdges > 0 ? MaxEdges : 1)> edge_;
  int count_ = 0;
};

}  // namespace plumbline
