#pragma once
// A view for propagation policies, which look at its times and poses alone.

#include <memory>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/feature/view.hpp"

namespace plumbline::test {

template <class SensorsT>
struct SmallView {
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;

  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> pyramid = std::make_unique<RigPyramid<Sensors>>();

  SmallView() { rig.vision.camera = {S(50), S(50), S(32), S(32), {}}; }

  /// The frame at `t_ns`, `dt` after the one before, which was taken at T_world_previous.
  View<Sensors> at(TimeNs t_ns, S dt, const SE3<S>& T_world_previous, const SE3<S>& T_body_cam) const {
    return {t_ns, dt, rig, *pyramid, *pyramid, {}, T_world_previous, T_body_cam, {rig.vision.camera, 64, S(0)}};
  }
};

/// The rotation of the image alignment.
template <class S>
struct SeenRotation {
  bool valid = false;
  SO3<S> R_cur_prev;
  bool moved = true;  ///< beside the translation that was guessed
};

}  // namespace plumbline::test
