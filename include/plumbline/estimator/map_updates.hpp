#pragma once
/// What the map of an estimator is told of the window: keyframes when they are adopted, changes of the world, and at a
/// reset the keyframes that are still in the window.                                              map/map.hpp

#include <cstdint>
#include <type_traits>
#include <utility>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/lie/sim3.hpp"
#include "plumbline/map/adopted_keyframe.hpp"
#include "plumbline/map/map.hpp"
#include "plumbline/map/world_change.hpp"

namespace plumbline {

template <class Parts, class MapT>
class MapUpdates {
  static_assert(Map<MapT, typename Parts::Sensors, typename Parts::Window, typename Parts::Landmarks>,
                "plumbline: a map has on_keyframe, on_retired, on_world_change, work and S_map_world, see map/map.hpp");

 public:
  using Sensors = typename Parts::Sensors;
  using S = typename Parts::S;
  using Backend = typename Parts::Backend;
  using Frames = typename Parts::Window;
  using Landmarks = typename Parts::Landmarks;

  MapUpdates(const Sensors& rig, const auto& options) : map_(rig, options) {}

  const MapT& map() const { return map_; }
  MapT& map() { return map_; }

  /// The frame in `slot` has become a keyframe. It is told once: the last one of an initialization is adopted twice.
  void adopt(int slot, const Frames& frames, const Landmarks& landmarks, const RigPyramid<Sensors>& image,
             const ImageView<const std::uint16_t>& depth, const RigShutter<Sensors>& shutter, const SE3<S>& T_body_cam,
             const Mat<S, 6, 6>& covariance) {
    if (std::exchange(adopted_, frames[slot].sequence) == frames[slot].sequence) return;
    map_.on_keyframe(AdoptedKeyframe<Frames, Sensors, Landmarks>(slot, frames, image, depth, shutter, T_body_cam,
                                                                 covariance, landmarks));
  }

  /// Poses are in another world and unit from now on, x_new = S_new_old x_old.
  void transform(const Sim3<S>& S_new_old, const SE3<S>& T_body_cam) {
    map_.on_world_change(WorldChange<S>{WorldChange<S>::Kind::transformed, S_new_old, T_body_cam});
  }
  /// The initialization was wrong: what the map learned of this world is wrong, and so is the window until its reset.
  void reject() {
    map_.on_world_change(WorldChange<S>{WorldChange<S>::Kind::rejected});
    is_rejected_ = true;
  }
  /// The window is emptied. The map gets its keyframes first, unless they are those of a rejected initialization.
  void reset(const Backend& backend, const Landmarks& landmarks, int temporary) {
    if (!std::exchange(is_rejected_, false)) hand_over(backend, landmarks, temporary);
    map_.on_world_change(WorldChange<S>{WorldChange<S>::Kind::reset});
  }
  /// Hands all keyframes of the window to the map, from the oldest to the newest; `temporary`: the slot of a frame that
  /// is none, or -1.
  void hand_over(const Backend& backend, const Landmarks& landmarks, int temporary) {
    if constexpr (std::is_empty_v<MapT>) return;
    const Frames& frames = backend.window();
    constexpr int none = -1;
    std::uint32_t last = 0;
    for (;;) {
      int next = none;
      for (int slot = 0; slot < Frames::slots; ++slot) {
        const auto& frame = frames[slot];
        if (!frame.used || slot == temporary || frame.sequence <= last) continue;
        if (next == none || frame.sequence < frames[next].sequence) next = slot;
      }
      if (next == none) break;
      last = frames[next].sequence;
      map_.on_retired(backend.retired(next, landmarks));
    }
  }

 private:
  [[no_unique_address]] MapT map_;
  std::uint32_t adopted_ = 0;  ///< sequence of the keyframe that the map was told of last
  bool is_rejected_ = false;   ///< the initialization of this window
};

}  // namespace plumbline
