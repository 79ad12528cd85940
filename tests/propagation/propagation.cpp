// What satisfies Propagation, and what does not.
#include "plumbline/propagation/propagation.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {

template <class S>
using Camera = Rig<Mono<Pinhole<S>>>;
template <class S>
using CameraAndImu = Rig<Rgbd<Pinhole<S>>, Imu>;

static_assert(Propagation<ConstantVelocity<Camera<float>>> && Propagation<ConstantVelocity<Camera<double>>>);
static_assert(Propagation<Inertial<CameraAndImu<float>>> && Propagation<Inertial<CameraAndImu<double>>>);
static_assert(!Propagation<Camera<float>> && !Propagation<int>);

/// Predicts the next frame, but knows nothing of keyframes and factors.
struct Guess {
  using S = float;
  using Sensors = Camera<float>;
  using Layout = VisualLayout;
  using State = FrameValue<S, Layout>;
  struct Factor {};
  struct Options {};
  template <int>
  struct Factors {};
  static constexpr bool has_imu_factors = false;
  Guess(const Sensors&, const Options&) {}
  void calibrate(auto&, const auto&) {}
  void begin_frame(TimeNs, const State*, S) {}
  SE3<S> T_body_cam(const SE3<S>& T) const { return T; }
  Prediction<State, S> predict(const State& x, const auto&, S, auto&&) { return {x, {}}; }
  bool can_propagate() const { return false; }
  Mat<S, 6, 6> grown_covariance(const Mat<S, 6, 6>& before, S) const { return before; }
  State restart(const State& x) { return x; }
  void mark_lost() {}
};
static_assert(Predicts<Guess> && !ChecksPoses<Guess> && !ProvidesFactors<Guess> && !Propagation<Guess>);

/// Has lost one call.
struct WithoutReset : Guess {
  using Guess::Guess;
  State restart(const State&) = delete;
};
static_assert(!Predicts<WithoutReset>);

// An IMU gives more than constant velocity has.
static_assert(!PropagatesByImu<ConstantVelocity<Camera<float>>> && PropagatesByImu<Inertial<CameraAndImu<float>>>);

// What a policy does not need its frames do not have.
static_assert(std::is_same_v<ConstantVelocity<Camera<float>>::Layout, VisualLayout>);
static_assert(std::is_same_v<Inertial<CameraAndImu<float>>::Layout, InertialLayout>);
static_assert(std::is_empty_v<ConstantVelocity<Camera<float>>::Factor>);

}  // namespace

TEST_CASE("propagation: without a sigma there is no prior about a pose") {
  const PosePrior<float> prior;
  CHECK_FALSE(prior.valid);
  CHECK(prior.sigma.norm() == 0);
}
