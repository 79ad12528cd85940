#pragma once
/// Points seen along a path, without images: exact truth at the level of observations.
///
///   P = T_world_cam^-1 X,   uv = project(P) + sigma_px n,   1/z = 1/P_z + sigma_inverse_depth n                (1)
/// The pixel of a landmark's first observation has no noise: it defines the landmark, as the pixels around it do that
/// are followed from image to image.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"

namespace plumbline::testing {

/// What a camera sees of one point, without noise.
struct SeenPoint {
  bool valid = false;  ///< in the image and in the range of the depth sensor
  Vec<double, 2> uv = Vec<double, 2>::Zero();
  Vec<double, 3> p_cam = Vec<double, 3>::Zero();
};

struct SimulatedPoints {
  static constexpr int width = 640, height = 480;
  Pinhole<double> camera{460, 460, 319.5, 239.5, {}};
  std::vector<Vec<double, 3>> p_world;
  double sigma_px = 0.5;
  double sigma_inverse_depth = 5e-3;  ///< [1/m]
  double noise_scale = 1;             ///< of (1); 0: exact measurements with these sigmas
  double outlier_share = 0;           ///< of all pixels but the first, off by outlier_px in a random direction
  double outlier_px = 20;
  double z_min = 0.5, z_max = 8;  ///< [m]

  /// Uniform in a box around the world's origin.
  void scatter(int count, const Vec<double, 3>& half_size, std::uint64_t seed) {
    Random random(seed);
    for (int i = 0; i < count; ++i) {
      const Vec<double, 3> u{random.uniform(), random.uniform(), random.uniform()};
      p_world.push_back((2 * u - Vec<double, 3>::Ones()).cwiseProduct(half_size));
    }
  }

  SeenPoint see(const SE3<double>& T_world_cam, std::size_t i) const {
    SeenPoint out;
    out.p_cam = T_world_cam.inverse() * p_world[i];
    const Projection<double> projection = camera.project(out.p_cam);
    if (!projection.valid) return out;
    out.uv = projection.uv;
    out.valid = out.uv.x() >= 0 && out.uv.y() >= 0 && out.uv.x() <= width - 1 && out.uv.y() <= height - 1 &&
                out.p_cam.z() >= z_min && out.p_cam.z() <= z_max;
    return out;
  }

  /// Takes the place of a front end of points: what the keyframe in `slot`, the latest frame, sees of the landmarks
  /// that are there, whose ids are indices of points, and new landmarks for all other points as long as there is room.
  template <class Store>
  void observe(Store& store, const SE3<double>& T_world_cam, int slot, Gaussian& noise) const {
    using S = typename Store::S;
    std::vector<bool> known(p_world.size());
    for (typename Store::Landmark& landmark : store.landmarks()) {
      known[landmark.id] = true;
      measure(see(T_world_cam, landmark.id), sigma_px, noise, landmark.current);
      landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
    }
    for (std::size_t i = 0; i < p_world.size(); ++i) {
      const SeenPoint seen = see(T_world_cam, i);
      if (known[i] || !seen.valid || store.landmarks().full()) continue;
      typename Store::Landmark landmark;
      landmark.id = static_cast<std::uint32_t>(i);
      landmark.anchor = slot;
      landmark.geometry.bearing = seen.p_cam.normalized().template cast<S>();
      measure(seen, 0, noise, landmark.current);
      landmark.observations[static_cast<std::size_t>(slot)] = landmark.current;
      landmark.located = true;
      landmark.geometry.inverse_range = landmark.current.depth.get().value * landmark.geometry.bearing.z();
      landmark.geometry.sigma_inverse_range = landmark.current.depth.get().sigma * landmark.geometry.bearing.z();
      store.landmarks().push_back(landmark);
    }
  }

 private:
  /// (1), into a PointObservation with depth.
  template <class Observation>
  void measure(const SeenPoint& seen, double sigma_uv, Gaussian& noise, Observation& out) const {
    out = {};
    out.valid = seen.valid;
    if (!out.valid) return;
    Vec<double, 2> uv = seen.uv + noise_scale * sigma_uv * noise.vector<2>();
    if (sigma_uv > 0 && noise.random().uniform() < outlier_share) uv += outlier_px * noise.vector<2>().normalized();
    out.pixel = out.uv = uv.cast<float>();
    out.L = Mat<float, 2, 2>::Identity() / float(sigma_px);
    auto depth = out.depth.get();
    using S = decltype(depth.value);
    depth.valid = true;
    depth.value = S(1 / seen.p_cam.z() + noise_scale * sigma_inverse_depth * noise());
    depth.sigma = S(sigma_inverse_depth);
    out.depth.set(depth);
  }
};

}  // namespace plumbline::testing
