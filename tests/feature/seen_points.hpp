#pragma once
// Points seen by keyframes, without images: exact truth at the level of observations.

#include <memory>
#include <vector>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/simulated_points.hpp"

namespace plumbline::test {

template <class S, class SensorsT = Rig<Rgbd<Pinhole<S>, 64 * 64>>>
struct SeenPoints {
  static constexpr int slots = 5, used = 4;
  using Sensors = SensorsT;
  using Kind = PointKind<Sensors>;
  using Observation = typename Kind::Observation;
  using Store = LandmarkStore<Kind, 32, slots>;
  using Landmark = typename Store::Landmark;
  using Window = FrameWindow<S, VisualLayout, slots>;

  testing::SimulatedPoints points;
  SE3<double> T_body_cam{SO3<double>::exp({0.1, -0.2, 0.3}), Vec<double, 3>(0.05, -0.1, 0.02)};
  Sensors rig{};
  std::unique_ptr<Store> store = std::make_unique<Store>(StoreOptions{});
  Window window;
  std::vector<SE3<double>> T_world_body;  ///< true poses of the keyframes

  /// `count` points in sight of all keyframes, anchored in the first one; inverse ranges and poses as they are.
  explicit SeenPoints(int count, double noise_scale = 1, std::uint64_t seed = 3) {
    rig.vision.camera = {S(460), S(460), S(319.5), S(239.5), {}};
    rig.vision.width = rig.vision.height = 64;
    points.noise_scale = noise_scale;
    points.scatter(count, {0.7, 0.5, 0.7}, seed);
    testing::Gaussian noise(seed);
    for (int k = 0; k < used; ++k) {
      T_world_body.push_back(
          SE3<double>(SO3<double>::exp({0.02 * k, -0.05 * k, 0.03 * k}), Vec<double, 3>(0.15 * k, 0.05 * k, -3)) *
          T_body_cam.inverse());
      window.insert(k, {T_world_body.back().template cast<S>()});
      points.observe(*store, T_world_cam(k), k, noise);
    }
    for (Landmark& landmark : store->landmarks()) {
      landmark.geometry.inverse_range = S(1 / points.see(T_world_cam(landmark.anchor), landmark.id).p_cam.norm());
      landmark.geometry.sigma_inverse_range = S(0.005);
      landmark.solved = true;
    }
  }

  SE3<double> T_world_cam(int slot) const { return T_world_body[std::size_t(slot)] * T_body_cam; }
};

}  // namespace plumbline::test
