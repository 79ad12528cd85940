// Lines located from observations without images: from depth, from two planes, and not at all.
#include "plumbline/frontend/line_location.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;
using test::SeenLines;

namespace {

template <class S>
using RgbdLines = SeenLines<S>;
template <class S>
using MonoLines = SeenLines<S, Rig<Mono<Pinhole<S>, 64 * 64>>>;

/// Landmarks of `Lines` that have yet to be located, seen by frame `latest`.
template <class Lines>
struct Scene : Lines {
  using S = typename Lines::Kind::Scalar;
  static constexpr int latest = 3;
  explicit Scene(int count, double noise_scale) : Lines(count, noise_scale) {
    for (auto& landmark : Lines::store->landmarks()) {
      landmark.located = false;
      landmark.geometry = {};
      landmark.current = landmark.observations[latest];
    }
  }
  void locate(typename Lines::Landmark& landmark, int from = latest) const {
    const SE3<S> T_body_cam_s = Lines::T_body_cam.template cast<S>();
    const SE3<S>&T_anchor = Lines::window.T_world_body(landmark.anchor), &T_latest = Lines::window.T_world_body(from);
    locate_line(landmark, RelativeView<S>(T_anchor, T_latest, T_body_cam_s), LineTriangulationOptions{},
                (T_latest * T_body_cam_s).inverse() * (T_anchor * T_body_cam_s));
  }
  /// How far the landmark is from the truth, in its own sigmas if it has noise.
  Vec<double, 4> error(std::size_t i) const {
    const auto& landmark = Lines::store->landmarks()[i];
    return minus(landmark.geometry.line.template cast<double>(), Lines::true_line(i, landmark.anchor));
  }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 2e-3 : 1e-8;

}  // namespace

TEMPLATE_TEST_CASE("line_location: depth beside the segment gives the line, in the frame that measured it", "", float,
                   double) {
  using S = TestType;
  Scene<RgbdLines<S>> scene(12, 0);
  for (std::size_t i = 0; i < 12; ++i) {
    auto& landmark = scene.store->landmarks()[i];
    locate_in_frame(landmark, 2);
    REQUIRE(landmark.located);
    REQUIRE(landmark.anchor == 2);
    REQUIRE(scene.error(i).norm() < tolerance<S>);
    REQUIRE(landmark.geometry.covariance.trace() > 0);
    // What was seen is what the frame saw.
    const SE3<double> T_cam_world = scene.T_world_cam(2).inverse();
    const Vec<double, 3> p = landmark.geometry.at(landmark.geometry.extent[0]).template cast<double>();
    REQUIRE((p - T_cam_world * scene.p_world[i]).norm() < 20 * tolerance<S>);
  }
}

TEMPLATE_TEST_CASE("line_location: edge in the anchor, edge and depth in the latest frame", "", float, double) {
  using S = TestType;
  Scene<RgbdLines<S>> scene(12, 0);
  for (std::size_t i = 0; i < 12; ++i) {
    auto& landmark = scene.store->landmarks()[i];
    landmark.observations[std::size_t(landmark.anchor)].clear_depth();
    const int anchor = landmark.anchor;
    scene.locate(landmark);
    REQUIRE(landmark.located);
    REQUIRE(landmark.anchor == anchor);
    REQUIRE(scene.error(i).norm() < tolerance<S>);
  }
}

TEST_CASE("line_location: errors are consistent with the covariance") {
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    SeenLines<double> seen(12, 1, seed);
    for (std::size_t i = 0; i < 12; ++i) {
      auto& landmark = seen.store->landmarks()[i];
      locate_in_frame(landmark, 1);
      if (!landmark.located) continue;
      const Vec<double, 4> e = minus(landmark.geometry.line, seen.true_line(i, 1));
      sum += e.dot(landmark.geometry.covariance.ldlt().solve(e)) / 4;
      ++count;
    }
  }
  REQUIRE(count > 1700);
  REQUIRE(sum / count == Approx(1).margin(0.15));
}

TEMPLATE_TEST_CASE("line_location: without depth, planes with parallax cut in the line", "", float, double) {
  using S = TestType;
  Scene<MonoLines<S>> scene(12, 0);
  int located = 0;
  for (std::size_t i = 0; i < 12; ++i) {
    auto& landmark = scene.store->landmarks()[i];
    scene.locate(landmark, landmark.anchor);  // no parallax
    REQUIRE_FALSE(landmark.located);
    scene.locate(landmark);
    if (!landmark.located) continue;
    ++located;
    REQUIRE(scene.error(i).norm() < 10 * tolerance<S>);
    REQUIRE(landmark.geometry.is_sound(landmark.seen_by_anchor().pixels.measured));
  }
  REQUIRE(located > 3);
}

TEMPLATE_TEST_CASE("line_location: from the filtered ends of the anchor's segment", "", float, double) {
  using S = TestType;
  double sum = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed < 30; ++seed) {
    for (const double noise_scale : {0.0, 1.0}) {
      MonoLines<S> seen(12, noise_scale, seed);
      for (std::size_t i = 0; i < 12; ++i) {
        auto& landmark = seen.store->landmarks()[i];
        landmark.located = false;
        const auto in_anchor = rays_of(landmark.seen_by_anchor().pixels);
        auto filter = SegmentDepthFilter<S>::around(S(0.33));
        for (int k = 0; k < seen.used; ++k) {
          const auto& observation = landmark.observations[std::size_t(k)];
          if (k == landmark.anchor || !observation.valid) continue;
          const SE3<double> T = seen.T_world_cam(k).inverse() * seen.T_world_cam(landmark.anchor);
          filter.update(in_anchor, rays_of(observation.pixels), T.template cast<S>());
        }
        if (!filter.converged(S(0.2), in_anchor)) continue;
        locate_from_ends(landmark, filter);
        REQUIRE(landmark.located);
        const Mat<double, 4, 4> covariance = landmark.geometry.covariance.template cast<double>();
        const Vec<double, 4> e =
            minus(landmark.geometry.line.template cast<double>(), seen.true_line(i, landmark.anchor));
        const double nees = e.dot(covariance.ldlt().solve(e)) / 4;
        if (noise_scale == 0) {
          REQUIRE(nees < 0.1);  // what the prior leaves
        } else {
          sum += nees;
          ++count;
        }
      }
    }
  }
  CAPTURE(count, sum / count);
  REQUIRE(count > 150);
  REQUIRE(sum / count > 0.4);  // few measurements leave a lower inlier share
  REQUIRE(sum / count < 1.4);
}

TEST_CASE("line_location: what does not fit the anchor's edge, or is no number, stays where it is") {
  Scene<RgbdLines<double>> scene(2, 0);
  testing::Gaussian noise(1);
  auto& moved = scene.store->landmarks()[0];
  moved.current = scene.observe(scene.p_world[0] + Vec<double, 3>(0.4, 0.4, 0.1), scene.q_world[0], 3, 0, noise);
  const auto before = moved.geometry;
  scene.locate(moved);
  REQUIRE((!moved.located || scene.error(0).norm() > 0.01));  // not by depth: at most by the planes
  if (!moved.located) REQUIRE(moved.geometry.line.plucker().n == before.line.plucker().n);

  auto& broken = scene.store->landmarks()[1];
  auto depth = broken.observations[1].depth.get();
  depth.measured.inverse_depth_measured[0] = std::numeric_limits<double>::quiet_NaN();
  broken.observations[1].depth.set(depth);
  locate_in_frame(broken, 1);
  REQUIRE_FALSE(broken.located);
}
