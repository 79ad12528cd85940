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

/// Predicts the next frame, but has no factors.
struct Guess {
  using S = float;
  using State = PoseState<S>;
  void begin_frame(TimeNs, const State*, S) {}
  Vec<S, 3> angular_rate() const { return Vec<S, 3>::Zero(); }
  Vec<S, 3> velocity(const State&) const { return Vec<S, 3>::Zero(); }
  bool can_propagate() const { return false; }
  State restart(const State& x) { return x; }
  void mark_lost() {}
};
static_assert(Predicts<Guess> && !ProvidesFactors<Guess> && !Propagation<Guess>);

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
