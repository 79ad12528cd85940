#include "plumbline/feature/row_ranges.hpp"

#include <memory>
#include <type_traits>

#include "../feature/seen_lines.hpp"
#include "../feature/seen_points.hpp"
#include "catch.hpp"

using namespace plumbline;

namespace {

constexpr double readout = 0.03, wrong = 0.1;  // [s], [1/m]: everything was taken to be that far away

/// An observation in the middle of the frame, as it was brought there from a row of the camera moving with `velocity`,
/// taken to see what is `1/wrong` away; exact is what it is where it is known how far away it is.
template <class S>
void perturb_extrinsics(PointObservation<S, true, true>& seen, const Vec<double, 3>& p_cam) {
  const Vec<float, 2> by_translation(60, -40);
  seen.uv -= float(readout * (1 / p_cam.norm() - wrong)) * by_translation;
  seen.derivative.set({Vec<float, 2>::Zero(), by_translation, float(wrong)});
}
template <class S>
Vec<S, 3> shift_of(const Vec<S, 3>& bearing) {
  const Vec<S, 3> tau_velocity(S(0.3), S(-0.2), S(0.1));
  return tau_velocity - tau_velocity.dot(bearing) * bearing;
}
template <class S>
void perturb_extrinsics(Vec<S, 3>& bearing, RowDerivative<S, 3>& derivative, S range) {
  derivative = {Vec<S, 3>::Zero(), shift_of(bearing), S(wrong)};
  bearing = normalized(bearing - S(readout) * (1 / range - S(wrong)) * derivative.by_translation);
}

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-6;

}  // namespace

TEMPLATE_TEST_CASE("row_ranges: points that rows saw from where the camera then was", "", float, double) {
  using S = TestType;
  using Scene = test::SeenPoints<S>;
  Scene exact(6, 0), scene(6, 0);
  auto& landmarks = scene.store->landmarks();
  for (auto& landmark : landmarks) {
    for (int k = 0; k < Scene::used; ++k) {
      auto& seen = landmark.observations[std::size_t(k)];
      if (seen.valid) perturb_extrinsics(seen, scene.points.see(scene.T_world_cam(k), landmark.id).p_cam);
    }
    landmark.current = landmark.observations[Scene::used - 1];
    RowDerivative<S, 3> derivative;
    perturb_extrinsics(landmark.geometry.bearing, derivative, 1 / landmark.geometry.inverse_range);
    landmark.geometry.derivative.set(derivative);
  }
  landmarks[5].located = false;
  const SE3<S> T_world_body = scene.window.T_world_body(Scene::used - 1),
               T_body_cam = scene.T_body_cam.template cast<S>();
  const auto error = [&](const auto& seen, std::size_t i, std::size_t k) {
    return double((seen.uv - exact.store->landmarks()[i].observations[k].uv).norm());
  };

  set_ranges(*scene.store, scene.window, T_world_body, T_body_cam, S(readout), /*all=*/false);
  for (std::size_t i = 0; i < 5; ++i) {
    CHECK(error(landmarks[i].current, i, Scene::used - 1) < 0.02);
    CHECK(error(landmarks[i].observations[1], i, 1) > 0.1);
  }
  set_ranges(*scene.store, scene.window, T_world_body, T_body_cam, S(readout), /*all=*/true);
  for (std::size_t i = 0; i < 5; ++i) {
    for (std::size_t k = 0; k < Scene::used; ++k) CHECK(error(landmarks[i].observations[k], i, k) < 0.02);
    const auto &point = landmarks[i].geometry, &truth = exact.store->landmarks()[i].geometry;
    CHECK(double((point.bearing - truth.bearing).norm()) < tolerance<S>);
    CHECK(point.bearing.norm() == Approx(1));
    CHECK(point.derivative.get().inverse_range == point.inverse_range);
  }
  CHECK(error(landmarks[5].observations[1], 5, 1) > 0.1);  // it has no place in space
}

TEMPLATE_TEST_CASE("row_ranges: both ends of lines, with what was measured along them", "", float, double) {
  using S = TestType;
  using Scene = test::SeenLines<S>;
  Scene exact(4, 0), scene(4, 0);
  auto& landmarks = scene.store->landmarks();
  for (std::size_t i = 0; i < 4; ++i) {
    for (int k = int(i) % 2; k < Scene::used; ++k) {
      auto& seen = landmarks[i].observations[std::size_t(k)];
      const SE3<double> T_cam_world = scene.T_world_cam(k).inverse();
      typename Scene::Observation::Derivatives derivatives;
      perturb_extrinsics(seen.pixels.measured.bearing_start, derivatives[0],
                         S((T_cam_world * scene.p_world[i]).norm()));
      perturb_extrinsics(seen.pixels.measured.bearing_end, derivatives[1], S((T_cam_world * scene.q_world[i]).norm()));
      seen.derivatives.set(derivatives);
    }
    landmarks[i].current = landmarks[i].observations[Scene::used - 1];
  }
  // Without a place in the frame it stays as it is.
  auto unseen = landmarks[0].current;
  unseen.valid = false;
  unseen.set_line(landmarks[0].geometry.line.plucker(), S(readout));
  CHECK(unseen.pixels.measured.bearing_start == landmarks[0].current.pixels.measured.bearing_start);

  const SE3<S> T_world_body = scene.window.T_world_body(Scene::used - 1),
               T_body_cam = scene.T_body_cam.template cast<S>();
  const auto error = [&](const auto& seen, std::size_t i, std::size_t k) {
    const auto &a = seen.pixels.measured, &b = exact.store->landmarks()[i].observations[k].pixels.measured;
    return double((a.bearing_start - b.bearing_start).norm() + (a.bearing_end - b.bearing_end).norm());
  };
  for (int times = 0; times < 2; ++times) {  // the range along a bearing that is off is a little off, too
    set_ranges(*scene.store, scene.window, T_world_body, T_body_cam, S(readout), /*all=*/true);
  }
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(error(landmarks[i].current, i, Scene::used - 1) < 5e-4);
    for (std::size_t k = i % 2; k < Scene::used; ++k) {
      const auto& seen = landmarks[i].observations[k];
      CAPTURE(i, k);
      CHECK(error(seen, i, k) < 5e-4);
      CHECK(seen.pixels.measured.bearing_end.norm() == Approx(1));
      const auto depth = seen.depth.get().measured;
      const Vec<S, 3>& start = seen.pixels.measured.bearing_start;
      CHECK(double((depth.m_start - start / start.z()).norm()) < tolerance<S>);
    }
  }
}
