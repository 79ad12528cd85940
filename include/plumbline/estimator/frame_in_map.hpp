#pragma once
/// Frames that the window has no pose for, while nothing is tracked: the map is asked for each of them, and where it
/// knows the place, this is the pose of the frame. For rigs without an IMU; with one the IMU bridges.
///                                                                       docs/concepts/outages.md, docs/math/map.md 6

#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/estimator/frame_report.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/map/found_frame.hpp"
#include "plumbline/state/health.hpp"

namespace plumbline {

/// Whether frames are sought in a map of that type.
template <class Parts, class MapT>
concept SeeksFrames = !Parts::Propagation::has_imu_factors && FindsFrames<MapT, View<typename Parts::Sensors>>;

/// Of other maps, and without one: no state, no code.
template <class Parts, class MapT>
class FrameInMap {
 public:
  static constexpr bool find(const auto& /*view*/, auto& /*map*/, const auto& /*predicted*/) { return false; }
  static void begin_at(const auto& /*view*/, auto& /*frames*/, auto& /*navigation*/) {}
  static constexpr bool has_begun_at(TimeNs /*t_ns*/) { return false; }
  static constexpr int distance_from(TimeNs /*t_ns*/) { return 0; }
  static void apply(auto& /*navigation*/, FrameReport& /*report*/) {}
};

template <class Parts, class MapT>
requires SeeksFrames<Parts, MapT>
class FrameInMap<Parts, MapT> {
 public:
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;

  /// Asks the map, once a frame.
  bool find(const View<Sensors>& view, MapT& map, const SE3<S>& T_world_predicted) {
    if (!has_asked_ || asked_ns_ != view.t_ns) {
      const SO3<S>& R_body_cam = view.T_body_cam.rotation();
      const SO3<S> R_prev_cur = view.T_world_previous.rotation().inverse() * T_world_predicted.rotation();
      is_found_ = map.find_frame(view, R_body_cam.inverse() * R_prev_cur.inverse() * R_body_cam, found_);
    }
    has_asked_ = true;
    asked_ns_ = view.t_ns;
    return is_found_;
  }
  /// A new initialization begins with the frame, where the map has it.
  void begin_at(const View<Sensors>& view, auto& frames, auto& navigation) {
    auto x = frames.latest();
    x.T_world_body = found_.T_world_body;
    frames.set_latest(x);
    set(navigation);
    first_ = found_;
    has_begun_ = true;
    begun_ns_ = view.t_ns;
  }
  /// Whether the initialization whose first view is of that time began so.
  bool has_begun_at(TimeNs t_ns) const { return has_begun_ && begun_ns_ == t_ns; }
  /// Distance of the frame from the first view of that time, where the map knows both so well that it tells it; else 0.
  S distance_from(TimeNs t_ns) const {
    if (!is_found_ || !has_begun_at(t_ns)) return S(0);
    const S distance = norm(Vec<S, 3>(found_.T_world_body.p() - first_.T_world_body.p()));
    S variance = S(0);
    for (int k = 3; k < 6; ++k) variance += found_.covariance(k, k) + first_.covariance(k, k);
    return distance > S(least_sigmas) * std::sqrt(variance) ? distance : S(0);
  }
  /// The pose of the map is that of the frame.
  void apply(auto& navigation, FrameReport& report) const {
    set(navigation);
    report.has_metric_pose = report.is_bridged = true;
    report.reason = HealthReason::map_only;
    report.tracked = found_.inliers;
  }

 private:
  void set(auto& navigation) const {
    navigation.set_pose(found_.T_world_body);
    navigation.set_covariance(found_.covariance);
  }

  static constexpr double least_sigmas = 4;  ///< of a distance: the unit is known to a quarter

  FoundFrame<S> found_, first_;
  bool has_asked_ = false, is_found_ = false, has_begun_ = false;
  TimeNs asked_ns_ = 0, begun_ns_ = 0;
};

}  // namespace plumbline
