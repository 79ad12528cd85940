#pragma once
/// Correction of observations for the range of their landmarks, with a rolling shutter. The translation of the camera
/// during the readout displaces an observation in proportion to the inverse range; when that is estimated for the first
/// time, or changes, the observation is corrected to the middle of the frame again.   docs/math/rolling_shutter.md (1b)

#include <array>
#include <cstddef>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// Corrects the observations of the latest frame, with the body at T_world_body; with `all` also those of the frames of
/// the window, anchors included.
template <class Store, class S = typename Store::S>
void set_ranges(Store& store, const auto& window, const SE3<typename Store::S>& T_world_body,
                const SE3<typename Store::S>& T_body_cam, typename Store::S readout_s, bool all) {
  using Kind = typename Store::Kind;
  constexpr std::size_t slots = static_cast<std::size_t>(Store::slots);
  std::array<SE3<S>, slots> T_world_cam;
  for (std::size_t k = 0; k < slots; ++k) T_world_cam[k] = window.T_world_body(int(k)) * T_body_cam;
  const SE3<S> T_cam_world = (T_world_body * T_body_cam).inverse();
  for (auto& landmark : store.landmarks()) {
    if (!landmark.located) continue;
    const std::size_t anchor = static_cast<std::size_t>(landmark.anchor);
    if (landmark.current.valid)
      Kind::set_range(landmark.geometry, landmark.current, T_cam_world * T_world_cam[anchor], readout_s);
    for (std::size_t k = 0; all && k < slots; ++k) {
      auto& seen = landmark.observations[k];
      if (!seen.valid || !window[int(k)].used) continue;
      if (k == anchor) {
        Kind::set_range_in_anchor(landmark.geometry, seen, readout_s);
      } else {
        Kind::set_range(landmark.geometry, seen, T_world_cam[k].inverse() * T_world_cam[anchor], readout_s);
      }
    }
  }
}

/// The same for all kinds; no operation with a global shutter.
template <SensorRig Sensors, class S = typename Sensors::Scalar>
void set_ranges(auto& landmarks, const auto& window, const View<Sensors>& view,
                const SE3<typename Sensors::Scalar>& T_world_body, typename Sensors::Scalar readout_s, bool all) {
  if constexpr (Sensors::rolls) {
    landmarks.for_each([&](auto& store) { set_ranges(store, window, T_world_body, view.T_body_cam, readout_s, all); });
  }
}

}  // namespace plumbline
