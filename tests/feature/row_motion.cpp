#include "plumbline/feature/row_motion.hpp"

#include <array>
#include <cstdint>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/feature/features.hpp"

using namespace plumbline;

namespace {

constexpr double readout = 0.02, range = 2;

/// Stores of a scene, as landmarks.
template <class Store>
struct One {
  Store& store;
  void for_each(auto&& visit) { visit(store); }
};

/// Seen at what was the middle of the frame, and corrected to it by the shutter motion.
template <class S>
void bring_to_middle(auto& seen, const auto& shutter) {
  seen.pixel = seen.uv;
  const auto still = shutter.still(seen.pixel.template cast<S>(), S(1 / range));
  seen.uv = still.uv.template cast<float>();
  seen.derivative.set({still.derivative.by_rotation.template cast<float>(),
                       still.derivative.by_translation.template cast<float>(), float(still.derivative.inverse_range)});
}

template <class Scene, class S = typename Scene::Kind::Scalar>
View<typename Scene::Sensors> moving(const Scene& scene, const RigPyramid<typename Scene::Sensors>& none,
                                     const Vec<double, 3>& rate, const Vec<double, 3>& velocity) {
  View<typename Scene::Sensors> view{0,
                                     S(0.05),
                                     scene.rig,
                                     none,
                                     none,
                                     {},
                                     SE3<S>(),
                                     scene.T_body_cam.template cast<S>(),
                                     {scene.rig.vision.camera, 480, S(readout), false}};
  view.set_motion(rate.template cast<S>(), velocity.template cast<S>(), S(range));
  return view;
}

const Vec<double, 3> thought_rate(0.2, -0.1, 0.3), thought_velocity(0.3, 0.1, -0.2), rate(-0.7, 0.9, 0.4),
    velocity(-0.4, 0.5, 0.3);

}  // namespace

TEMPLATE_TEST_CASE("row_motion: points are where the motion that is found brings them, those of other frames stay", "",
                   float, double) {
  using S = TestType;
  using Scene = test::SeenPoints<S>;
  Scene scene(8, 0);
  const auto none = std::make_unique<RigPyramid<typename Scene::Sensors>>();
  const auto thought = moving(scene, *none, thought_rate, thought_velocity),
             found = moving(scene, *none, rate, velocity);
  One<typename Scene::Store> landmarks{*scene.store};
  for (const int slot : {0, 2}) {
    for (auto& landmark : landmarks.store.landmarks()) {
      auto& seen = landmark.observations[std::size_t(slot)];
      bring_to_middle<S>(seen, thought.shutter);
      if (landmark.anchor != slot) continue;
      auto& point = landmark.geometry;
      point.bearing = scene.rig.vision.camera.unproject(seen.uv.template cast<S>()).bearing;
      point.derivative.set(
          thought.shutter.bearing_derivative(seen.pixel.template cast<S>(), point.bearing, S(1 / range)));
    }
    const auto before = landmarks.store.landmarks();
    set_motion(landmarks, slot, found, S(readout));
    for (std::size_t i = 0; i < before.size(); ++i) {
      const auto &landmark = landmarks.store.landmarks()[i], &was = before[i];
      const auto& seen = landmark.observations[std::size_t(slot)];
      const auto still = found.shutter.still(seen.pixel.template cast<S>(), S(1 / range));
      const double off = (was.observations[std::size_t(slot)].uv.template cast<S>() - still.uv).norm();
      CHECK((seen.uv.template cast<S>() - still.uv).norm() < 0.05 * off + 0.02);
      CHECK((seen.derivative.get().by_rotation.template cast<S>() - still.derivative.by_rotation).norm() < 1e-3 * 500);
      CHECK(landmark.observations[1].uv == was.observations[1].uv);
      if (landmark.anchor == slot) {
        const Vec<S, 3> bearing = scene.rig.vision.camera.unproject(still.uv).bearing;
        CHECK((landmark.geometry.bearing - bearing).norm() < 0.05 * (was.geometry.bearing - bearing).norm() + 1e-4);
      } else {
        CHECK(landmark.geometry.bearing == was.geometry.bearing);
      }
    }
  }
}

TEMPLATE_TEST_CASE("row_motion: the latest frame alone is moved before it is a keyframe", "", float, double) {
  using S = TestType;
  using Scene = test::SeenPoints<S>;
  Scene scene(8, 0);
  const auto none = std::make_unique<RigPyramid<typename Scene::Sensors>>();
  const auto thought = moving(scene, *none, thought_rate, thought_velocity),
             found = moving(scene, *none, rate, velocity);
  One<typename Scene::Store> landmarks{*scene.store};
  bool lost = true;  // the first one is not seen now
  for (auto& landmark : landmarks.store.landmarks()) {
    landmark.current = landmark.observations[0];
    bring_to_middle<S>(landmark.current, thought.shutter);
    landmark.current.valid = !lost;
    lost = false;
  }
  const auto before = landmarks.store.landmarks();
  set_motion(landmarks, found, S(readout));
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto &landmark = landmarks.store.landmarks()[i], &was = before[i];
    const auto still = found.shutter.still(was.current.pixel.template cast<S>(), S(1 / range));
    const double off = (was.current.uv.template cast<S>() - still.uv).norm();
    if (i == 0) {
      CHECK(landmark.current.uv == was.current.uv);
    } else {
      CHECK((landmark.current.uv.template cast<S>() - still.uv).norm() < 0.05 * off + 0.02);
    }
    CHECK(landmark.observations[0].uv == was.observations[0].uv);
    CHECK(landmark.geometry.bearing == was.geometry.bearing);
  }
}

TEMPLATE_TEST_CASE("row_motion: lines turn with both ends of what their anchor saw", "", float, double) {
  using S = TestType;
  using Scene = test::SeenLines<S>;
  Scene scene(4, 0);
  const auto none = std::make_unique<RigPyramid<typename Scene::Sensors>>();
  const auto found = moving(scene, *none, rate, velocity);
  One<typename Scene::Store> landmarks{*scene.store};
  const auto before = landmarks.store.landmarks();
  for (const int slot : {0, 1}) set_motion(landmarks, slot, found, S(readout));
  int anchored = 0;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const auto &landmark = landmarks.store.landmarks()[i], &was = before[i];
    const auto &seen = landmark.observations[1], &was_seen = was.observations[1];
    const auto &ends = seen.pixels.measured, &were = was_seen.pixels.measured;
    const RowDerivative<S, 3> thought = was_seen.derivatives.get()[1],
                              derivative = found.shutter.bearing_derivative(seen.segment.end.template cast<S>(),
                                                                            were.bearing_end, thought.inverse_range);
    const Vec<S, 3> change = S(readout) * (derivative.by_readout() - thought.by_readout());
    CHECK((ends.bearing_end - normalized(were.bearing_end + change)).norm() < 1e-6);
    if (landmark.anchor > 1) continue;
    ++anchored;
    // It was seen where it is, and still is.
    const Vec<S, 2> error = landmark.seen_by_anchor().pixels.measured.residual(landmark.geometry.line.plucker());
    const Vec<S, 2> was_error = was.seen_by_anchor().pixels.measured.residual(was.geometry.line.plucker());
    CHECK((error - was_error).norm() < 0.3);
    CHECK((landmark.geometry.line.plucker().n - was.geometry.line.plucker().n).norm() > 1e-4);
  }
  REQUIRE(anchored >= 3);
}
