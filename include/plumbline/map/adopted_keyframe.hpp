#pragma once
/// A keyframe as the map learns of it: its image, its state, and the landmarks that it observes. All of it is valid
/// during the call only; the map copies what it keeps.

#include <cstddef>
#include <cstdint>

#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class StateT, SensorRig Sensors, class Landmarks>
class AdoptedKeyframe {
 public:
  using State = StateT;
  using S = typename Sensors::Scalar;

  template <class Frame>
  AdoptedKeyframe(int slot, const Frame& frame, const RigPyramid<Sensors>& pyramid, const SE3<S>& T_body_camera,
                  const Landmarks& landmarks)
      : sequence(frame.sequence),
        t_ns(frame.t_ns),
        x(frame.state.value()),
        image(pyramid),
        T_body_cam(T_body_camera),
        slot_(slot),
        landmarks_(landmarks) {}

  const std::uint32_t sequence;  ///< number of the frame since the estimator was made; never repeated
  const TimeNs t_ns;
  const State x;  ///< present estimate; the window moves it until the frame retires
  const RigPyramid<Sensors>& image;
  const SE3<S> T_body_cam;

  /// visit(landmark, observation): all landmarks that the frame observes, located or not.
  void for_each_observation(auto&& visit) const {
    landmarks_.for_each([&](const auto& store) {
      for (const auto& landmark : store.landmarks()) {
        if (landmark.anchor == slot_) {
          visit(landmark, landmark.seen_by_anchor());
        } else if (const auto& seen = landmark.observations[static_cast<std::size_t>(slot_)]; seen.valid) {
          visit(landmark, seen);
        }
      }
    });
  }

 private:
  int slot_;
  const Landmarks& landmarks_;
};

}  // namespace plumbline
