#pragma once
// Lines with points on them in the keyframes of SeenPoints, with exact truth, by a camera without depth.

#include <cstdint>
#include <memory>

#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/feature/collinear_kind.hpp"
#include "plumbline/sensor/mono.hpp"

namespace plumbline::test {

/// Six lines with three points on each.
template <class S>
struct SeenCollinear : SeenPoints<S, Rig<Mono<Pinhole<S>, 64 * 64>>> {
  using Base = SeenPoints<S, Rig<Mono<Pinhole<S>, 64 * 64>>>;
  using LineKind = CollinearKind<typename Base::Sensors>;
  using LineStore = LandmarkStore<LineKind, 8, Base::slots>;
  static constexpr int count = 6, on_each = 3;

  testing::Gaussian noise{7};
  std::unique_ptr<LineStore> lines = std::make_unique<LineStore>(StoreOptions{});

  SeenCollinear() : Base(0) {
    Random random(5);
    for (int i = 0; i < count; ++i) {
      const Vec<double, 3> p = random_vector(random, 0.6), q = p + 0.6 * random_vector(random, 1).normalized();
      typename LineStore::Landmark line;
      line.anchor = i % 2;
      for (int k = line.anchor; k < Base::used; ++k) line.observations[std::size_t(k)] = segment(p, q, k);
      const SE3<double> T_cam_world = Base::T_world_cam(line.anchor).inverse();
      line.geometry.line = Line3<double>::through(T_cam_world * p, T_cam_world * q).template cast<S>();
      line.located = line.solved = true;
      for (int n = 0; n < on_each; ++n) add_point(p + double(n) / (on_each - 1) * (q - p), (i + n) % 2, line);
      lines->landmarks().push_back(line);
    }
  }

  typename LineKind::Observation segment(const Vec<double, 3>& p, const Vec<double, 3>& q, int slot) {
    const SE3<double> T = Base::T_world_cam(slot).inverse();
    return observe_segment<typename LineKind::Observation>(Base::points.camera, T * p, T * q, 0, noise);
  }
  /// Seen by all frames from its anchor on.
  void add_point(const Vec<double, 3>& p_world, int anchor, typename LineStore::Landmark& line) {
    typename Base::Landmark point;
    point.id = std::uint32_t(100 + Base::store->landmarks().size());
    point.anchor = anchor;
    point.located = point.solved = true;
    for (int k = anchor; k < Base::used; ++k) {
      const Vec<double, 3> p_cam = Base::T_world_cam(k).inverse() * p_world;
      auto& seen = point.observations[std::size_t(k)];
      seen.valid = true;
      seen.pixel = seen.uv = Base::points.camera.project(p_cam).uv.template cast<float>();
      if (k != anchor) continue;
      point.geometry.bearing = p_cam.normalized().template cast<S>();
      point.geometry.inverse_range = S(1 / p_cam.norm());
    }
    line.appearance.points.push_back({.id = point.id});
    Base::store->landmarks().push_back(point);
  }
};

}  // namespace plumbline::test
