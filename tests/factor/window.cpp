// Factors in a window without images: what they determine, what stays of them when their frame is retired or dropped.
//                                                                                              docs/math/factors.md
#include <cmath>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/factor/absolute_position.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {

constexpr int slots = 5;
using Sensors = Rig<Rgbd<Pinhole<double>, 64 * 64>>;
using CameraPropagation = ConstantVelocity<Sensors>;
using Landmarks = typename Features<Points<10>>::template Landmarks<Sensors, slots>;

/// The same rows, and nothing of them in the prior.
template <class S>
struct Forgotten : AbsolutePosition<S> {
  static constexpr bool is_marginalized = false;
};

using Window = typename SlidingWindow<slots, Flow, AbsolutePosition, Forgotten>::Backend<CameraPropagation, Landmarks>;
using Plain = typename SlidingWindow<slots>::Backend<CameraPropagation, Landmarks>;
static_assert(TakesFactor<Window, AbsolutePosition<double>> && TakesFactor<Window, Forgotten<double>>);
static_assert(!TakesFactor<Window, AbsolutePosition<float>> && !TakesFactor<Plain, AbsolutePosition<double>>);
static_assert(std::is_same_v<Plain, WindowBackend<CameraPropagation, Landmarks, slots>>);
static_assert(std::is_empty_v<Plain::FrameFactors>);
static_assert(sizeof(Plain) + sizeof(Window::FrameFactors) < sizeof(Window) + alignof(Window));  // without: no byte

struct Discard {
  void on_retired(const auto&) {}
};

constexpr double sigma = 0.01;
template <class Factor>
Factor antenna(const SE3<double>& T, const Vec<double, 3>& lever, const Vec<double, 3>& error = {0, 0, 0}) {
  Factor out;
  out.p_measured = T * lever + error;
  out.L = Mat<double, 3, 3>::Identity() / sigma;
  out.p_body_antenna = lever;
  return out;
}

struct Scene {
  std::unique_ptr<Window> backend = std::make_unique<Window>(WindowOptions{}, ConstantVelocityOptions{});
  std::unique_ptr<Landmarks> landmarks = std::make_unique<Landmarks>(StoreOptions{});
  Sensors rig{};
  Discard map;

  void optimize() { backend->optimize(rig, SE3<double>(), *landmarks); }
  Mat<double, 6, 6> covariance() const {
    Mat<double, 6, 6> out;
    REQUIRE(backend->covariance_of_newest(out));
    return out;
  }
};

}  // namespace

TEST_CASE("factors in a window: a position and the prior of the first frame meet by their information") {
  Scene scene;
  WindowOptions options;
  const int slot = scene.backend->start(0, {});
  AbsolutePosition<double> factor = antenna<AbsolutePosition<double>>({}, {0, 0, 0}, {2e-3, 0, 0});
  factor.L = Mat<double, 3, 3>::Identity() / options.sigma_first_position;
  REQUIRE(scene.backend->add_factor(slot, factor));
  scene.optimize();
  CHECK(scene.backend->window().T_world_body(slot).p().x() == Approx(1e-3));
  const double variance = options.sigma_first_position * options.sigma_first_position;
  CHECK(scene.covariance()(3, 3) == Approx(variance / 2));
  scene.backend->start(1, {});  // another world
  scene.optimize();
  CHECK(scene.covariance()(3, 3) == Approx(variance));
}

TEST_CASE("factors in a window: three antennas determine the pose of a frame") {
  Scene scene;
  scene.backend->start(0, {});
  const SE3<double> truth(SO3<double>::exp({0.1, -0.2, 0.15}), {1, 2, 3});
  const int slot = scene.backend->insert(1, {SE3<double>(SO3<double>(), {1.1, 1.9, 3.2})}, {});
  for (int k = 0; k < 3; ++k) {
    REQUIRE(scene.backend->add_factor(
        slot, antenna<AbsolutePosition<double>>(truth, k == 0 ? Vec<double, 3>(0, 0, 0) : Vec<double, 3>::Unit(k))));
  }
  for (int k = 0; k < 3; ++k) scene.optimize();
  CHECK(minus(scene.backend->window().T_world_body(slot), truth).norm() < 1e-6);
}

TEST_CASE("factors in a window: a retired frame leaves its rows in the prior, if they are marginalized") {
  const auto run = [](auto of_first) {
    using Factor = decltype(of_first);
    Scene scene;
    const int first = scene.backend->start(0, {});
    const SE3<double> T(SO3<double>::exp({0, 0.3, 0}), {2, 0, 0});
    const int second = scene.backend->insert(1, {T}, {});
    scene.backend->hold_distance(first, second, 2, 1e-4);
    Factor factor = antenna<Factor>({}, {0, 0, 0}, {1e-3, 0, 0});
    factor.L = Mat<double, 3, 3>::Identity() / 1e-3;
    REQUIRE(scene.backend->add_factor(first, factor));
    for (int k = 0; k < 3; ++k) {
      const Vec<double, 3> lever = k == 0 ? Vec<double, 3>(0, 0, 0) : Vec<double, 3>::Unit(k);
      REQUIRE(scene.backend->add_factor(second, antenna<AbsolutePosition<double>>(T, lever)));
    }
    scene.optimize();
    scene.optimize();
    const Mat<double, 6, 6> before = scene.covariance();
    const SE3<double> T_before = scene.backend->window().T_world_body(second);
    scene.backend->retire(scene.rig, SE3<double>(), *scene.landmarks, first, scene.map);
    scene.optimize();
    const Mat<double, 6, 6> after = scene.covariance();
    const double moved = minus(scene.backend->window().T_world_body(second), T_before).norm();
    return Vec<double, 2>((after - before).norm() / before.norm(), moved);
  };
  const Vec<double, 2> kept = run(AbsolutePosition<double>()), forgotten = run(Forgotten<double>());
  CAPTURE(kept.transpose(), forgotten.transpose());
  CHECK(kept[0] < 1e-3);
  CHECK(kept[1] < 1e-5);
  CHECK(forgotten[1] > 1e-4);
}

TEST_CASE("factors in a window: a frame that is dropped leaves none, and its slot begins without") {
  Scene scene;
  scene.backend->start(0, {});
  const int slot = scene.backend->insert(1, {}, {});
  for (int k = 0; k < 3; ++k) {
    REQUIRE(scene.backend->add_factor(slot, antenna<AbsolutePosition<double>>({}, Vec<double, 3>::Unit(k), {1, 0, 0})));
  }
  scene.backend->drop(*scene.landmarks, slot);
  CHECK(scene.backend->frame_factors().cost(scene.backend->window()) == 0);
  CHECK(!scene.backend->add_factor(slot, antenna<AbsolutePosition<double>>({}, {0, 0, 0})));  // there is no frame
  REQUIRE(scene.backend->insert(2, {}, {}) == slot);
  scene.optimize();
  CHECK(scene.backend->window().T_world_body(slot).p().norm() < 1e-9);
}

TEST_CASE("factors in a window: what is not finite is refused") {
  Scene scene;
  const int slot = scene.backend->start(0, {});
  AbsolutePosition<double> factor = antenna<AbsolutePosition<double>>({}, {0, 0, 0});
  factor.p_measured.x() = std::nan("");
  CHECK(!scene.backend->add_factor(slot, factor));
  scene.optimize();
  CHECK(scene.backend->window().T_world_body(slot).p().norm() == 0);
}
