// What is a backend, and what is none.
#include "plumbline/backend/backend.hpp"

#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {

using Visual = Rig<Rgbd<Pinhole<float>>>;
using VisualInertial = Rig<Mono<Pinhole<double>>, Imu>;
template <class Sensors>
using Landmarks = typename Features<Points<100>, Lines<40>>::template Landmarks<Sensors, 5>;

using Camera = typename SlidingWindow<5>::Backend<ConstantVelocity<Visual>, Landmarks<Visual>>;
using CameraAndImu = typename SlidingWindow<5>::Backend<Inertial<VisualInertial>, Landmarks<VisualInertial>>;
static_assert(Backend<Camera> && Backend<CameraAndImu>);
static_assert(InertialBackend<CameraAndImu> && HoldsScale<CameraAndImu> && HoldsDistance<CameraAndImu>);

/// Has frames, and nothing that estimates them.
struct Frames {
  using S = float;
  using Sensors = Visual;
  using Window = Camera::Window;
  using State = Camera::State;
  using Factor = Camera::Factor;
  using Landmarks = Camera::Landmarks;
  struct Options {};
  const Window& window() const { return window_; }
  Window& window() { return window_; }
  const Camera::Factors& factors() const { return factors_; }
  Window window_;
  Camera::Factors factors_{0};
};
static_assert(HasFrames<Frames> && !Backend<Frames> && !InertialBackend<Frames> && !HoldsScale<Frames>);
static_assert(!HasFrames<Camera::Window> && !Backend<int>);

// A frame of a camera is a pose and no more, without factors to others.
static_assert(Camera::Layout::dim == state::Pose::dim && CameraAndImu::Layout::dim == InertialLayout::dim);
static_assert(sizeof(Camera::State) == sizeof(SE3<float>));
static_assert(std::is_empty_v<Camera::Factors> && !std::is_empty_v<CameraAndImu::Factors>);

// Of a shutter that rolls both find the readout time; one alone that has nothing to estimate does not.
using GlobalRig = Rig<Mono<Pinhole<double>, 64 * 64, Global>>;
using Bundle = typename DirectGaussNewton<5>::Backend<ConstantVelocity<Visual>, Landmarks<Visual>>;
using OfGlobal = typename SlidingWindow<5>::Backend<ConstantVelocity<GlobalRig>, Landmarks<GlobalRig>>;
static_assert(EstimatesReadout<Camera> && EstimatesReadout<Bundle>);
static_assert(!EstimatesReadout<OfGlobal> && !EstimatesReadout<Frames>);

}  // namespace

TEST_CASE("backend: has its frames and their covariance from the first one on") {
  const auto backend = std::make_unique<Camera>(Camera::Options{}, ConstantVelocityOptions{});
  const SE3<float> T(SO3<float>::exp({0.1f, 0.2f, 0.3f}), Vec<float, 3>(1, 2, 3));
  const int first = backend->start(7, {T});
  CHECK(backend->window().size() == 1);
  CHECK(backend->window()[first].t_ns == 7);
  CHECK(minus(backend->window().T_world_body(first), T).norm() == 0);
  Mat<float, 6, 6> covariance;
  REQUIRE(backend->covariance_of_newest(covariance));
  const WindowOptions options;
  for (int k = 0; k < 6; ++k) {
    const double sigma = k < 3 ? options.sigma_first_rotation : options.sigma_first_position;
    CHECK(covariance(k, k) == Approx(sigma * sigma));
  }
}

TEST_CASE("backend: a frame that is dropped leaves no trace") {
  using Landmark = decltype(std::declval<Landmarks<Visual>>().get<0>().landmarks()[0]);
  const auto backend = std::make_unique<Camera>(Camera::Options{}, ConstantVelocityOptions{});
  const auto landmarks = std::make_unique<Landmarks<Visual>>(StoreOptions{}, StoreOptions{});
  backend->start(0, {});
  std::remove_cvref_t<Landmark> landmark;
  landmark.current.valid = true;
  REQUIRE(landmarks->get<0>().add(landmark, 0));
  const int slot = backend->insert(1, {}, {});
  landmarks->for_each([&](auto& store) { store.record(slot); });
  REQUIRE(landmarks->get<0>().landmarks()[0].observations[std::size_t(slot)].valid);
  backend->drop(*landmarks, slot);
  CHECK(backend->window().size() == 1);
  CHECK(backend->window().newest() == 0);
  REQUIRE(landmarks->get<0>().landmarks().size() == 1);
  CHECK_FALSE(landmarks->get<0>().landmarks()[0].observations[std::size_t(slot)].valid);
}
