#pragma once
// Landmarks of all kinds followed by direct alignment on rendered frames of a room whose truth is exact.

#include <algorithm>
#include <memory>
#include <vector>

#include "estimator/simulation.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/frontend/direct_alignment.hpp"
#include "plumbline/frontend/front_ends.hpp"
#include "plumbline/frontend/image_pair.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"

namespace plumbline::test {

inline const SimulatedRgbd& direct_room() {
  static const SimulatedRgbd simulated(10);
  return simulated;
}
template <class S>
using DirectRgbd = Rig<Rgbd<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;
template <class S>
using DirectMono = Rig<Mono<Pinhole<S>, SimulatedRgbd::width * SimulatedRgbd::height>>;

template <class SensorsT, class Set, class Policy = DirectAlignment>
struct DirectLife {
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;
  static constexpr int slots = 3;
  using Ends = FrontEnds<Policy, Sensors, slots, Set>;
  using Landmarks = typename Ends::Landmarks;

  Sensors rig{};
  std::unique_ptr<ImagePair<Sensors>> images = std::make_unique<ImagePair<Sensors>>(RotationAlignmentOptions{});
  std::unique_ptr<Ends> ends;
  std::unique_ptr<Landmarks> landmarks;
  FrameWindow<S, VisualLayout, slots> window;

  explicit DirectLife(const typename Ends::Options& options = {})
      : ends(std::make_unique<Ends>(options)), landmarks(new Landmarks(Ends::make_landmarks(options))) {
    rig.vision.camera = {S(268), S(268), S(159.5), S(119.5), {}};
    rig.vision.width = SimulatedRgbd::width;
    rig.vision.height = SimulatedRgbd::height;
  }

  static SE3<S> T(int i) { return direct_room().T_world_cam[std::size_t(i)].template cast<S>(); }
  View<Sensors> view(int i) {
    typename Sensors::Frame frame;
    frame.t_ns = direct_room().t_ns[std::size_t(i)];
    frame.gray = direct_room().frames[std::size_t(i)].gray.view();
    if constexpr (Sensors::has_depth) frame.depth = direct_room().frames[std::size_t(i)].depth.view();
    images->take_in(frame);
    return images->view(rig, frame, SE3<S>(), {}, S(0.05));
  }
  int keyframe(const View<Sensors>& seen, int i) {
    const int slot = window.insert(seen.t_ns, {T(i)});
    ends->detect(seen, window, *landmarks, slot);
    return slot;
  }
  /// The first frame, at the truth.
  void begin(int i = 0) {
    const View<Sensors> seen = view(i);
    keyframe(seen, i);
    images->keep(seen, T(i));
  }
  /// Where the features of a store are from where the truth has them: median [px].
  template <class Store>
  float error_px(const Store& store, int i) const {
    std::vector<float> errors;
    for (const auto& landmark : store.landmarks()) {
      if (!landmark.current.valid || !landmark.located) continue;
      const Vec<S, 3> p_world = window.T_world_body(landmark.anchor) * Store::Kind::middle(landmark.geometry);
      errors.push_back(
          (landmark.current.uv - rig.vision.camera.project(T(i).inverse() * p_world).uv.template cast<float>()).norm());
    }
    if (errors.empty()) return 1e9f;
    const auto middle = errors.begin() + std::ptrdiff_t(errors.size() / 2);
    std::nth_element(errors.begin(), middle, errors.end());
    return *middle;
  }
};

}  // namespace plumbline::test
