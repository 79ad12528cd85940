#pragma once
/// A keyframe of the map: its pose, and the features by which it is recognized.              docs/math/map.md

#include <array>
#include <cstddef>
#include <cstdint>

#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/tracking/binary_descriptor.hpp"

namespace plumbline {

/// A feature of a keyframe: its descriptor, its bearing and, of a located landmark, its range.
struct PlaceFeature {
  static constexpr std::uint32_t no_landmark = 0xFFFFFFFF, no_point = 0xFFFFFFFF;

  BinaryDescriptor descriptor;
  Vec<float, 3> bearing{0, 0, 1};        ///< unit, in the camera
  float sigma_rad = 0;                   ///< angular noise of the bearing
  float range = 0;                       ///< from the camera, in the unit of the keyframe's world; 0: not known
  float sigma_range = 0;                 ///< [unit of the range]
  std::uint32_t landmark = no_landmark;  ///< its id in the window
  std::uint32_t point = no_point;        ///< number of the point of the map, map_points.hpp
  bool is_recalled = false;              ///< as which it was found again, not tracked

  bool is_located() const { return range > 0; }
};

template <class S, std::size_t MaxFeatures>
struct PlaceKeyframe {
  using Scalar = S;
  TimeNs t_ns = 0;
  SE3<S> T_world_body;           ///< latest estimate; the window moves it until the frame retires
  SE3<S> T_world_body_in_graph;  ///< the estimate that its pose in the pose graph accounts for
  SE3<S> T_body_cam;
  Mat<S, 6, 6> covariance = zeros<S, 6, 6>();  ///< of T_world_body when it became a keyframe, right increment [rad, m]
  SE3<S> T_before;                             ///< this body in that of the keyframe before
  Mat<S, 6, 6> Q = zeros<S, 6, 6>();           ///< covariance of `T_before`
  S growth = S(0);                             ///< of the variance of its position, from the keyframe before [m^2]
  std::uint32_t id = 0;                        ///< sequence of its frame
  std::uint32_t world = 0;                     ///< number of the world that its pose and its ranges are of
  bool is_moved = false;                       ///< T_world_body and T_world_body_in_graph differ
  bool is_retired = false;
  bool begins_mean = false;  ///< `Q` is the growth of its covariance alone
  bool is_new = false;       ///< its edge is not in the pose graph yet
  bool is_known = false;     ///< the window has told `Q`
  bool is_fixed = false;     ///< `T_before` is final: this keyframe or the one before has retired
  FixedVector<PlaceFeature, MaxFeatures> features;

  /// x_new = S_new_old x_old of its camera, whose extrinsics become T_body_cam_new; `T_before` is to follow.
  void transform(const Sim3<S>& S_new_old, const SE3<S>& T_body_cam_new) {
    const S s = S_new_old.scale();
    const SE3<S> T_world_cam = T_world_body * T_body_cam;
    T_world_body =
        SE3<S>(S_new_old.rotation() * T_world_cam.rotation(), S_new_old * T_world_cam.p()) * T_body_cam_new.inverse();
    T_body_cam = T_body_cam_new;
    for (int i = 0; i < 6; ++i) {
      for (int j = 0; j < 6; ++j) {
        const S by = (i < 3 ? S(1) : s) * (j < 3 ? S(1) : s);
        covariance(i, j) *= by;
        Q(i, j) *= by;
      }
    }
    for (PlaceFeature& feature : features) {
      feature.range *= float(s);
      feature.sigma_range *= float(s);
    }
    is_new = true;
  }
  /// Of the features with a range, in the unit of the keyframe's world; 1 without one.
  S mean_range() const {
    S sum = S(0);
    int n = 0;
    for (const PlaceFeature& feature : features) {
      if (!feature.is_located()) continue;
      sum += S(feature.range);
      ++n;
    }
    return n > 0 ? sum / S(n) : S(1);
  }
};

}  // namespace plumbline
