#pragma once
/// A map of keyframes: recognizes places, closes loops, and finds the map again after a reset.     docs/math/map.md
///
///   Estimator<Sensors, Features, Backend, NoClock, KeyframeMap<200>> vio{rig, options, map_options};
///   vio.map().S_map_world()      correction of the world, which itself never jumps
///
/// It describes the features of keyframes (place_learner.hpp) and hands them to keyframe_map_core.hpp.

#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/map/found_frame.hpp"
#include "plumbline/map/keyframe_map_core.hpp"
#include "plumbline/map/keyframe_map_counts.hpp"
#include "plumbline/map/keyframe_map_options.hpp"
#include "plumbline/map/loop_alignment.hpp"
#include "plumbline/map/map_archive.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/map/place_learner.hpp"
#include "plumbline/map/point_recall.hpp"
#include "plumbline/map/world_change.hpp"
#include "plumbline/residual/relative_pose.hpp"
#include "plumbline/residual/relative_pose_yaw.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// The mode of the pose graph of a rig.
template <class Sensors>
using PlaceResidual =
    std::conditional_t<Sensors::has_imu, RelativePoseYawResidual<typename Sensors::Scalar>,
                       std::conditional_t<Sensors::has_depth, RelativePoseResidual<typename Sensors::Scalar>,
                                          RelativeSim3Residual<typename Sensors::Scalar>>>;

/// MaxPatches of each keyframe make loops exact (loop_alignment.hpp); 0: none are kept, and no image.
/// FindsPoints: points of the map are found again in new keyframes, and a local bundle adjustment follows. Off: in one
/// of four recordings of a camera alone poses become three times worse, docs/decisions/141.
template <int MaxKeyframes, std::size_t MaxFeatures = 200, int MaxLoops = 40, bool FindsPoints = false,
          std::size_t MaxPatches = MaxFeatures / 5>
struct KeyframeMap {
  using Options = KeyframeMapOptions;

  template <SensorRig Sensors>
  class MapOf {
   public:
    using Core = KeyframeMapCore<PlaceResidual<Sensors>, MaxKeyframes, MaxFeatures, MaxLoops, FindsPoints>;
    using S = typename Sensors::Scalar;
    using Places = typename Core::Places;
    using Stage = typename Core::Stage;

    MapOf(const Sensors& rig, const Options& options)
        : core_(of_sensors(options)),
          is_read_only_(options.localize_only),
          learner_(rig, options),
          frame_learner_(rig, options),
          recall_(rig, options.recall),
          alignment_(rig, options.alignment) {}

    /// See keyframe_map_core.hpp.
    const Places& places() const { return core_.places(); }
    const KeyframeMapCounts& counts() const { return core_.counts(); }
    Sim3<S> S_map_world() const { return core_.S_map_world(); }
    bool covariance_in_map(typename Core::Covariance& out) const { return core_.covariance_in_map(out); }
    void save(auto&& sink) const { core_.save(sink); }
    MapArchiveError load(std::span<const std::byte> bytes) { return core_.load(bytes); }
    int loaded() const { return core_.loaded(); }
    bool is_in_map() const { return core_.is_in_map(); }
    Stage stage() const { return core_.stage(); }
    void work() {
      core_.work(
          [this](int slot, const auto& old, const SE3<S>& T, auto&& visit) { alignment_.align(slot, old, T, visit); });
    }

    void on_keyframe(const auto& keyframe) {
      keyframe.for_each_frame([this](std::uint32_t id, const SE3<S>& T) { core_.set_pose(id, T); });
      auto* const learned = core_.begin_keyframe(keyframe.sequence, keyframe.t_ns, keyframe.x.T_world_body,
                                                 keyframe.T_body_cam, keyframe.covariance);
      if (!learned) return;
      learner_.learn_tracked(keyframe, *learned);
      if constexpr (Core::has_points) {
        if (!is_read_only_) recall(keyframe, *learned);
      }
      learner_.learn_corners(keyframe, *learned);
      alignment_.learn(core_.places().slot(core_.places().size() - 1), *learned, keyframe.image,
                       [this](std::size_t n) { return learner_.pixel(n); });
      if (core_.finish_keyframe()) alignment_.set_image(keyframe.image, keyframe.shutter);
    }
    void on_retired(const auto& retired) {
      retired.for_each_neighbor([this](std::uint32_t a, std::uint32_t b, const Mat<S, 6, 6>& covariance) {
        core_.set_covariance(a, b, covariance);
      });
      if (auto* const keyframe = core_.retire(retired.sequence, retired.x.T_world_body)) {
        learner_.retire(retired, *keyframe);
        core_.points().drop_unlocated(*keyframe);
      }
    }
    void on_world_change(const WorldChange<S>& change) { core_.change_world(change); }
    /// See found_frame.hpp.
    bool find_frame(const auto& view, const SO3<S>& R_cur_prev, FoundFrame<S>& found) requires Core::finds_frames {
      frame_learner_.learn_frame(view, core_.begin_frame());
      return core_.find_frame(view, R_cur_prev, found);
    }

   private:
    static Options of_sensors(Options options) {
      if (Sensors::has_imu && !Sensors::has_depth) options.common_range_error = options.inertial_range_error;
      return options;
    }

    /// The points that the keyframe sees: those it tracks, those that it shows again, and new ones.
    template <class Adopted>
    void recall(const Adopted& keyframe, typename Core::Keyframe& learned) {
      auto& places = core_.places();
      auto& points = core_.points();
      const int k = places.size() - 1;
      points.take_tracks(places, k);
      const auto again = recall_.recall(places, points, k, keyframe.image);
      core_.count_recalled(again.size());
      learner_.learn_recalled(keyframe, again, learned, [&](std::size_t feature, std::uint32_t point) {
        points.observe(places, k, feature, point);
      });
      keyframe.for_each_observation([&](const auto& landmark, const auto&) {
        if constexpr (requires {
                        landmark.appearance.patch;
                        landmark.geometry.inverse_range;
                      }) {
          if (!keyframe.is_anchor_of(landmark)) return;
          for (std::size_t n = 0; n < learned.features.size(); ++n) {
            if (learned.features[n].landmark == landmark.id && learned.features[n].point == PlaceFeature::no_point)
              points.add(places, k, n, landmark.appearance.patch);
          }
        }
      });
    }

    Core core_;
    bool is_read_only_;
    PlaceLearner<Sensors, MaxFeatures> learner_;
    std::conditional_t<Core::finds_frames, PlaceLearner<Sensors, 2 * MaxFeatures>, NoFrameLocalizer> frame_learner_;
    std::conditional_t<Core::has_points, PointRecall<Sensors, Places, MaxFeatures / 2>, NoRecall> recall_;
    std::conditional_t<MaxPatches == 0, NoLoopAlignment, LoopAlignment<Sensors, MaxKeyframes, MaxPatches>> alignment_;
  };
  template <class Parts>
  using Map = MapOf<typename Parts::Sensors>;
};

}  // namespace plumbline
