#pragma once
/// Correction of observations for the motion of a camera with a rolling shutter during one frame. Without an IMU the
/// motion is estimated from the pose of the frame and, for keyframes, that of the next frame; observations are then
/// corrected to the middle of the frame again.                                  docs/math/rolling_shutter.md (1c), (1f)

#include <cstddef>
#include <type_traits>

#include "plumbline/feature/view.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// Observations of the latest frame, that of `view`.
template <SensorRig Sensors>
void set_motion(auto& landmarks, const View<Sensors>& view, typename Sensors::Scalar readout_s) {
  if constexpr (Sensors::rolls) {
    landmarks.for_each([&](auto& store) {
      for (auto& landmark : store.landmarks()) {
        if (landmark.current.valid) landmark.current.set_motion(view.shutter, readout_s);
      }
    });
  }
}

/// Observations of the frame in `slot`, whose shutter is that of `then`.
template <SensorRig Sensors>
void set_motion(auto& landmarks, int slot, const View<Sensors>& then, typename Sensors::Scalar readout_s) {
  if constexpr (Sensors::rolls) {
    landmarks.for_each([&](auto& store) {
      using Kind = typename std::remove_cvref_t<decltype(store)>::Kind;
      for (auto& landmark : store.landmarks()) {
        auto& seen = landmark.observations[static_cast<std::size_t>(slot)];
        if (!seen.valid) continue;
        if (landmark.anchor == slot) {
          Kind::set_motion_in_anchor(landmark.geometry, seen, then.shutter, readout_s);
        } else {
          seen.set_motion(then.shutter, readout_s);
        }
      }
    });
  }
}

}  // namespace plumbline
