#pragma once
// Lines seen by keyframes, without images: exact truth at the level of observations.

#include <Eigen/LU>
#include <memory>
#include <vector>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/landmark_store.hpp"
#include "plumbline/feature/line_kind.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/state/frame_window.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "residual/points.hpp"

namespace plumbline::test {

/// Covariances as those of long edges and of good depth, each with a correlation.
inline Mat<double, 2, 2> pixels_covariance() { return endpoint_covariance(0.4f, 0.5f, 8).cast<double>(); }
inline Mat<double, 2, 2> depth_covariance() {
  Mat<double, 2, 2> covariance;
  covariance << 9e-6, 2e-6, 2e-6, 1.6e-5;
  return covariance;
}

/// A segment with endpoints p, q [camera] as it is measured: `noise_scale` times its sigma off, and claiming that
/// sigma. Of depth and derivatives an Observation keeps what it has.
template <class Observation>
Observation observe_segment(const Pinhole<double>& camera, const Vec<double, 3>& p, const Vec<double, 3>& q,
                            double noise_scale, testing::Gaussian& noise) {
  using Pixels = decltype(Observation::pixels);
  using S = typename Pixels::S;
  Observation out;
  const Vec<double, 2> a = camera.project(p).uv, b = camera.project(q).uv, along = (b - a).normalized();
  const Vec<double, 2> across(-along.y(), along.x());
  const Mat<double, 2, 2> L = *square_root_information(pixels_covariance());
  const Mat<double, 2, 2> L_z = *square_root_information(depth_covariance());
  const Vec<double, 2> off = noise_scale * L.inverse() * Vec<double, 2>{noise(), noise()};
  const Vec<double, 2> off_z = noise_scale * L_z.inverse() * Vec<double, 2>{noise(), noise()};
  const Vec<double, 2> start = a + off[0] * across, end = b + off[1] * across;
  const LineObservation<double> seen = observe_line(camera, start, end);
  const LineReprojection<double>& pixels = seen.reprojection;
  out.pixels = Pixels({pixels.bearing_start.template cast<S>(), pixels.bearing_end.template cast<S>(),
                       pixels.px_per_rad.template cast<S>()},
                      pixels_covariance().cast<S>());
  out.valid = seen.valid && out.pixels.valid;
  out.segment = {start.cast<float>(), end.cast<float>(), 20};
  const Vec<double, 2> inverse_depth(1 / p.z() + off_z[0], 1 / q.z() + off_z[1]);
  out.set_depth(inverse_depth.cast<S>(), depth_covariance().cast<S>());
  typename Observation::Derivatives derivatives;
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec<double, 3>& bearing = i == 0 ? pixels.bearing_start : pixels.bearing_end;
    derivatives[i].by_rotation = (0.3 * Vec<double, 3>(0.2, -0.5, 0.4).cross(bearing)).template cast<S>() * S(i + 1);
  }
  out.derivatives.set(derivatives);
  return out;
}

template <class S, class SensorsT = Rig<Rgbd<Pinhole<S>, 64 * 64>>>
struct SeenLines {
  static constexpr int slots = 5, used = 4;
  using Sensors = SensorsT;
  using Kind = LineKind<Sensors>;
  using Observation = typename Kind::Observation;
  using Store = LandmarkStore<Kind, 16, slots>;
  using Landmark = typename Store::Landmark;
  using Window = FrameWindow<S, VisualLayout, slots>;

  Pinhole<double> camera{460, 460, 319.5, 239.5, {}};
  SE3<double> T_body_cam{SO3<double>::exp({0.1, -0.2, 0.3}), Vec<double, 3>(0.05, -0.1, 0.02)};
  Sensors rig{};
  std::unique_ptr<Store> store = std::make_unique<Store>(StoreOptions{});
  Window window;
  std::vector<SE3<double>> T_world_body;         ///< true poses of the keyframes
  std::vector<Vec<double, 3>> p_world, q_world;  ///< true endpoints

  /// `count` lines, anchored in the first two keyframes and seen by all; poses as they are.
  explicit SeenLines(int count, double noise_scale = 1, std::uint64_t seed = 3) {
    rig.vision.camera = {S(460), S(460), S(319.5), S(239.5), {}};
    rig.vision.width = rig.vision.height = 64;
    Random random(seed);
    testing::Gaussian noise(seed);
    for (int k = 0; k < used; ++k) {
      T_world_body.push_back(
          SE3<double>(SO3<double>::exp({0.02 * k, -0.05 * k, 0.03 * k}), Vec<double, 3>(0.15 * k, 0.05 * k, -3)) *
          T_body_cam.inverse());
      window.insert(k, {T_world_body.back().template cast<S>()});
    }
    for (int i = 0; i < count; ++i) {
      p_world.push_back(random_vector(random, 0.8));
      do q_world.resize(p_world.size() - 1), q_world.push_back(random_vector(random, 0.8));
      while ((q_world.back() - p_world.back()).norm() < 0.5);
      Landmark landmark;
      landmark.id = std::uint32_t(i);
      landmark.anchor = i % 2;
      for (int k = i % 2; k < used; ++k) {
        landmark.observations[std::size_t(k)] = observe(p_world.back(), q_world.back(), k, noise_scale, noise);
      }
      landmark.geometry.line = true_line(std::size_t(i), landmark.anchor).template cast<S>();
      landmark.located = landmark.solved = true;
      const LineReprojection<S>& seen = landmark.seen_by_anchor().pixels.measured;
      landmark.geometry.set_extent(SE3<S>(), seen.bearing_start, seen.bearing_end);
      landmark.current = landmark.observations[used - 1];
      store->landmarks().push_back(landmark);
    }
  }

  SE3<double> T_world_cam(int slot) const { return T_world_body[std::size_t(slot)] * T_body_cam; }
  Line3<double> true_line(std::size_t i, int slot) const {
    const SE3<double> T_cam_world = T_world_cam(slot).inverse();
    return Line3<double>::through(T_cam_world * p_world[i], T_cam_world * q_world[i]);
  }
  Observation observe(const Vec<double, 3>& p, const Vec<double, 3>& q, int slot, double noise_scale,
                      testing::Gaussian& noise) const {
    const SE3<double> T_cam_world = T_world_cam(slot).inverse();
    return observe_segment<Observation>(camera, T_cam_world * p, T_cam_world * q, noise_scale, noise);
  }
};

/// Measurements in double.
template <class Observation>
LineReprojection<double> pixels_of(const Observation& seen) {
  const auto& pixels = seen.pixels.measured;
  return {pixels.bearing_start.template cast<double>(), pixels.bearing_end.template cast<double>(),
          pixels.px_per_rad.template cast<double>()};
}
template <class Observation>
LineInverseDepth<double> depth_of(const Observation& seen) {
  const auto depth = seen.depth.get().measured;
  return {depth.m_start.template cast<double>(), depth.m_end.template cast<double>(),
          depth.inverse_depth_measured.template cast<double>()};
}

}  // namespace plumbline::test
