#pragma once
/// A keyframe as the map learns of it: its image, its state, and the landmarks that it observes. All of it is valid
/// during the call only; the map copies what it keeps.

#include <cstddef>
#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

template <class Frames, SensorRig Sensors, class Landmarks>
class AdoptedKeyframe {
 public:
  using State = typename Frames::Value;
  using S = typename Sensors::Scalar;

  AdoptedKeyframe(int slot, const Frames& frames, const RigPyramid<Sensors>& pyramid,
                  const ImageView<const std::uint16_t>& depth_image, const RigShutter<Sensors>& rows,
                  const SE3<S>& T_body_camera, const Mat<S, 6, 6>& pose_covariance, const Landmarks& landmarks)
      : sequence(frames[slot].sequence),
        t_ns(frames[slot].t_ns),
        x(frames[slot].state.value()),
        image(pyramid),
        depth(depth_image),
        shutter(rows),
        T_body_cam(T_body_camera),
        covariance(pose_covariance),
        slot_(slot),
        frames_(frames),
        landmarks_(landmarks) {}

  const std::uint32_t sequence;  ///< number of the frame since the estimator was made; never repeated
  const TimeNs t_ns;
  const State x;  ///< present estimate; the window moves it until the frame retires
  const RigPyramid<Sensors>& image;
  const ImageView<const std::uint16_t> depth;  ///< empty without a depth image
  const RigShutter<Sensors> shutter;           ///< with the motion of the camera
  const SE3<S> T_body_cam;
  const Mat<S, 6, 6> covariance;  ///< of the pose in its world, right increment [rad, m]

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

  bool is_anchor_of(const auto& landmark) const { return landmark.anchor == slot_; }

  /// visit(sequence, T_world_body): all frames of the window, with their present poses.
  void for_each_frame(auto&& visit) const {
    for (int k = 0; k < Frames::slots; ++k) {
      if (frames_[k].used) visit(frames_[k].sequence, frames_.T_world_body(k));
    }
  }
  /// A located landmark in the camera of this keyframe [m].
  template <class Landmark>
  Vec<S, 3> in_camera(const Landmark& landmark) const {
    const Vec<S, 3> p = Landmark::Kind::middle(landmark.geometry);
    if (landmark.anchor == slot_) return p;
    const SE3<S> T_world_cam = frames_.T_world_body(slot_) * T_body_cam;
    return T_world_cam.inverse() * Vec<S, 3>(frames_.T_world_body(landmark.anchor) * (T_body_cam * p));
  }

 private:
  int slot_;
  const Frames& frames_;
  const Landmarks& landmarks_;
};

}  // namespace plumbline
