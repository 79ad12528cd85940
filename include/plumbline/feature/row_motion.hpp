#pragma once
/// How a camera with a rolling shutter moved while one frame was read. Without an IMU that is known for good when the
/// frame after it is: its rows are then brought to the middle of the frame anew.   docs/math/rolling_shutter.md (1c)

#include <cstddef>
#include <type_traits>

#include "plumbline/feature/view.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// In the frame of `slot`, whose shutter is that of `then`.
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
