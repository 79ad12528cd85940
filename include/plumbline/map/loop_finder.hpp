#pragma once
/// A loop between two keyframes: geometric verification, and the tests that it must pass.        docs/math/map.md 3
///
/// The verified pose (place_pose.hpp) is accepted as a loop if the odometry between the keyframes does not exclude it
/// (loop_gate.hpp), if it is told apart from other places that look alike (loop_aliases.hpp), if it agrees with the
/// vertical that both keyframes know from an IMU, and, before the first loop to a place is used, if a second keyframe
/// soon after predicts the same.

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/keyframe_map_counts.hpp"
#include "plumbline/map/keyframe_map_options.hpp"
#include "plumbline/map/loop_aliases.hpp"
#include "plumbline/map/loop_gate.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/map/place_pose.hpp"

namespace plumbline {

/// A verified pose of keyframe j in keyframe i.
template <class Places>
struct PlaceLoop {
  static constexpr std::uint32_t nothing = 0;

  std::uint32_t i = nothing, j = nothing;  ///< ids
  typename Places::Pose T_i_j;
  typename Places::Covariance covariance = zeros<typename Places::Covariance>();  ///< of its right increment
  bool is_inserted = false;
};

template <class Places, std::size_t MaxFeatures>
class LoopFinder {
 public:
  using S = typename Places::S;
  using Pose = typename Places::Pose;
  using Residual = typename Places::Residual;
  using Keyframe = typename Places::Keyframe;
  using Graph = typename Places::Graph;
  using Covariance = typename Places::Covariance;
  using Loop = PlaceLoop<Places>;
  static constexpr int none = Places::none;

  explicit LoopFinder(const KeyframeMapOptions& options) : options_(options) {}

  /// The loop between the keyframes i and j, verified and tested alone.
  bool find(const Places& places, int i, int j, Loop& loop, KeyframeMapCounts& counts, const auto& align) {
    const Keyframe &old = places.keyframe(i), &current = places.keyframe(j);
    const Pose between = places.graph().pose(i).inverse() * places.graph().pose(j);
    const Sim3<S> S_old_current = Places::Poses::to_sim3(between);
    const SE3<S> prior =
        old.T_body_cam.inverse() * SE3<S>(S_old_current.rotation(), S_old_current.t()) * current.T_body_cam;
    const SO3<S> R_old = old.T_world_body.rotation() * old.T_body_cam.rotation(),
                 R_current = current.T_world_body.rotation() * current.T_body_cam.rotation();
    const PlaceVertical<S> vertical{R_old, R_current.inverse() * Vec<S, 3>(0, 0, 1)};
    const PlacePose<S>& pose =
        pose_solver_.solve(old, current, prior, options_.pose, Places::has_gravity ? &vertical : nullptr,
                           [&](const SE3<S>& T, auto&& visit) { align(places.slot(i), old, T, visit); });
    if (!pose.valid) return false;
    if (Places::has_scale && !(pose.log_scale_sigma < S(0.1))) return false;
    if (tilt(old, current, pose.T_old_current) > S(options_.max_tilt_rad)) {
      ++counts.rejected_by_tilt;
      return false;
    }
    const S scale = Places::has_scale ? std::exp(pose.log_scale) : S(1);
    const SE3<S>& T_c = pose.T_old_current;  // the lever arms are in the units of their worlds
    const SE3<S> T_body =
        old.T_body_cam * T_c * SE3<S>(current.T_body_cam.rotation(), scale * current.T_body_cam.p()).inverse();
    Mat<S, 6, 6> P_c = S(options_.pose_inflation) * pose.covariance;
    const Vec<S, 3> shared = S(options_.common_range_error) * (T_c.rotation().inverse() * T_c.p());  // map.md (3a)
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) P_c(3 + a, 3 + b) += shared[a] * shared[b];
    Mat<S, 6, 6> P = transported(P_c, T_c, old.T_body_cam.inverse() * T_body);
    for (int a = 0; a < 6; ++a) {  // of the unit of the current world
      for (int b = 0; b < 6; ++b) P(a, b) /= (a < 3 ? S(1) : scale) * (b < 3 ? S(1) : scale);
    }
    for (int a = 0; a < 3; ++a) {
      P(a, a) += S(options_.graph.odometry.sigma_rotation * options_.graph.odometry.sigma_rotation);
      P(3 + a, 3 + a) += S(options_.graph.odometry.sigma_position * options_.graph.odometry.sigma_position);
    }
    loop.i = old.id;
    loop.j = current.id;
    loop.T_i_j = Places::Poses::to_pose(T_body, scale);
    loop.covariance = Places::Poses::of_increment(P, places.graph().pose(i) * loop.T_i_j, pose.log_scale_sigma);
    const auto predicted = predict_loop(places.graph(), i, j, loop.T_i_j, loop.covariance, options_.gate);
    if (!test_loop(predicted, loop.T_i_j, options_.gate).accepted) {
      const Vec<S, 3> a =
          Places::Poses::to_sim3(predicted.T_i * loop.T_i_j).t() - Places::Poses::to_sim3(predicted.T_j).t();
      if (norm(a) > S(options_.min_alias) * Places::Poses::to_sim3(predicted.T_i).scale() * old.mean_range())
        aliases_.add(a);
      ++counts.rejected_by_gate;
      return false;
    }
    if (!aliases_.confuse(predicted, loop.T_i_j, options_.alias_odds)) return true;
    ++counts.rejected_as_ambiguous;
    return false;
  }
  /// Matches of the last loop that was found: (feature of i, feature of j).
  std::span<const DescriptorMatch> matches() const { return pose_solver_.inliers(); }
  /// Whether there are places that look alike.
  bool knows_aliases() const { return aliases_.size() > 0; }
  /// The unit or the axes of the map have changed.
  void forget_aliases() { aliases_.clear(); }
  /// Whether the last verified loop, with the odometry since, predicts this one.
  bool agrees(const Places& places, const Loop& last, const Loop& loop) const {
    const Graph& graph = places.graph();
    const int i1 = places.find(last.i), j1 = places.find(last.j), i2 = places.find(loop.i), j2 = places.find(loop.j);
    if (last.j == Loop::nothing || i1 == none || j1 == none || j2 <= j1) return false;
    if (!last.is_inserted && j2 - j1 > options_.agreement_keyframes) return false;
    if (last.is_inserted && j2 - j1 > 4 * options_.agreement_keyframes) return false;
    OdometryChain<Residual> chain(graph.pose(i1) * last.T_i_j);
    for (int k = j1 + 1; k <= j2; ++k)
      chain.append(graph.odometry(k).residual.measured, graph.odometry(k).covariance());
    const auto lin = Residual{loop.T_i_j}.linearize(graph.pose(i2), chain.pose());
    if (!lin.valid) return false;
    const Covariance A = Residual::transport(graph.pose(i1) * last.T_i_j, chain.pose());
    const Covariance predicted = product_transposed(product(A, last.covariance), A);
    Covariance innovation = loop.covariance;
    const Covariance known = product_transposed(
        product(lin.J_r_j, Covariance(predicted + S(options_.gate.covariance_inflation) * chain.covariance())),
        lin.J_r_j);
    innovation += known;
    const Result<Covariance> L = square_root_information(innovation);
    if (!L) return false;
    const double chi2 = double(squared_norm(Vec<S, Residual::dim>(times(*L, lin.r))));
    return chi_square_survival(chi2, Residual::dim) >= options_.agreement_share;
  }

 private:
  /// Angle between the verticals that both keyframes know; 0 without an IMU.
  S tilt(const Keyframe& old, const Keyframe& current, const SE3<S>& T_old_current) const {
    if constexpr (!Places::has_gravity) {
      return S(0);
    } else {
      const Vec<S, 3> up(0, 0, 1);
      const SO3<S> R_old = old.T_world_body.rotation() * old.T_body_cam.rotation() * T_old_current.rotation();
      const SO3<S> R_current = current.T_world_body.rotation() * current.T_body_cam.rotation();
      const Vec<S, 3> a = R_old.inverse() * up, b = R_current.inverse() * up;
      return norm(Vec<S, 3>(a - b));
    }
  }

  KeyframeMapOptions options_;
  LoopAliases<S> aliases_;
  PlacePoseSolver<S, MaxFeatures> pose_solver_;
};

}  // namespace plumbline
