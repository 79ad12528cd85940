#include "plumbline/estimator/dead_reckoned_pose.hpp"

#include <cmath>

#include "../motion/small_view.hpp"
#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/recovery.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/motion/inertial_options.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

constexpr double dt = 0.05;  // [s]
const Vec<double, 3> stationary_bias_gyro(0, 0, 1e-3), bias_gyro(0.01, -0.02, 0.03), bias_accel(0.1, 0, -0.1);

/// The IMU samples of a frame whose body moves evenly and does not turn.
struct Samples {
  bool unusable = false;
  Preintegration<double> since_frame() const {
    Preintegration<double> samples(
        ImuNoise{.gyro_density = 1e-4, .accel_density = 1e-3, .gyro_walk = 1e-6, .accel_walk = 1e-5});
    const Vec<double, 3> gyro(0, 0, 0), accel(0, 0, standard_gravity<double>);
    samples.add({dt, gyro, gyro, accel, accel});
    return samples;
  }
  bool is_unusable() const { return unusable; }
  bool is_missing() const { return false; }
};

/// The interface of an odometry that is used.
struct Body {
  using S = double;
  using State = NavState<double>;
  using Covariance = Mat<double, 6, 6>;
  using Sensors = Rig<Mono<Pinhole<double>, 64 * 64>, Imu>;
  struct Options {
    RecoveryOptions recovery;
    InertialOptions motion;
  };
  struct Motion {
    Samples samples;
    bool initialized = false, stationary = false;
    bool is_initialized() const { return initialized; }
    bool is_stationary() const { return stationary; }
    const Samples& imu() const { return samples; }
    State stationary_state() const { return {{}, zeros<double, 3>(), stationary_bias_gyro, zeros<double, 3>()}; }
  };
  struct Window {
    State x;
    const State& latest() const { return x; }
    void set_latest(const State& state) { x = state; }
    int oldest() const { return 0; }
    const SE3<double>& T_world_body(int) const { return x.T_world_body; }
  };
  struct RigState {
    SE3<double> T_body_cam() const { return {}; }
  };

  Options options;
  Motion motion;
  RigState rig_state;
  Estimate<double> estimate;
  WorldFrameUncertainty<double> world_uncertainty{0, true};
  Window frames;

  Window& window() { return frames; }
  const Window& window() const { return frames; }
  void publish(const Covariance& P) { estimate.covariance = P; }
  void set_health(HealthState state, HealthReason reason) { estimate.health = {state, reason}; }
  double sigma(int k) const { return std::sqrt(estimate.covariance(k, k)); }
};

/// Poses of estimated scale.
struct Initializer {
  static constexpr bool needs_second_view = true;
  double sigma = 0.1;
  Vec<double, 3> velocity = Vec<double, 3>(0.5, 0, 0);
  double scale_sigma() const { return sigma; }
  double gravity_sigma() const { return 0.02; }
  Vec<double, 3> latest_velocity() const { return velocity; }
  NavState<double> state_of(const SE3<double>& T_ref_rotated, const SE3<double>&) const { return {T_ref_rotated}; }
};

struct Run {
  test::SmallView<Body::Sensors> small_view;
  Body body;
  Initializer initializer;
  DeadReckonedPose<Body, Initializer> pose{body.options};

  void advance(double s) {
    const View<Body::Sensors> view = small_view.at(0, dt, {}, {});
    for (double t = 0; t < s - dt / 2; t += dt) pose.advance(body, view);
    pose.publish(body);
  }
  bool publishes(double x, double scale_sigma) {
    body.set_health(HealthState::initializing, HealthReason::aligning);
    initializer.sigma = scale_sigma;
    body.frames.x.T_world_body = SE3<double>({}, {x, 0, 0});
    pose.publish_up_to_scale(body, initializer);
    return body.estimate.health.reason == HealthReason::scale_uncertain;
  }
};

}  // namespace

TEST_CASE("dead_reckoned_pose: nothing is published before initialization") {
  Run run;
  run.advance(1);
  CHECK(run.body.estimate.T_world_body.p().isZero());
  CHECK(run.body.estimate.covariance == identity<double, 6>());
}

TEST_CASE("dead_reckoned_pose: propagates an up-to-scale pose by the IMU until a better one is published") {
  Run run;
  REQUIRE(run.publishes(1, 0.1));
  CHECK(run.body.sigma(3) == Approx(0.1 + run.body.options.motion.stationary_position_sigma));
  CHECK(run.body.sigma(0) == Approx(0.02));
  CHECK(run.body.estimate.v_world_body.x() == 0.5);
  run.initializer.velocity = {0, 0, 0};
  run.advance(1);
  CHECK(run.body.estimate.T_world_body.p().x() == Approx(1.5).epsilon(1e-3));
  const double known = run.body.sigma(3);
  CHECK(known > 0.15);
  CHECK(run.publishes(1.6, 0.05));
  CHECK(run.body.estimate.T_world_body.p().x() == 1.6);
}

TEST_CASE("dead_reckoned_pose: an up-to-scale pose outside the gate, or less certain, is not published") {
  Run run;
  REQUIRE(run.publishes(1, 0.1));
  run.advance(0.5);
  CHECK_FALSE(run.publishes(3, 0.02));
  CHECK_FALSE(run.publishes(1.2, 0.5));
  CHECK(run.body.estimate.T_world_body.p().x() == Approx(1.25).epsilon(1e-3));
  CHECK(run.publishes(1.2, 0.1));
}

TEST_CASE("dead_reckoned_pose: propagates from a stationary pose, from up-to-scale poses only after the time limit") {
  Run run;
  run.pose.publish_stationary(run.body, 0.2);
  CHECK(run.body.estimate.health.reason == HealthReason::aligning);
  CHECK(run.body.sigma(3) == Approx(run.body.options.motion.stationary_position_sigma));
  CHECK(run.body.frames.x.bias_gyro == stationary_bias_gyro);
  run.advance(1);
  REQUIRE(run.publishes(0.2, 0.5));
  run.advance(dt);
  CHECK(run.body.estimate.T_world_body.p().isZero(1e-9));
  run.advance(2.5);
  REQUIRE(run.publishes(0.2, 0.5));
  run.advance(dt);
  CHECK(run.body.estimate.T_world_body.p().x() > 0.2);
}

TEST_CASE("dead_reckoned_pose: a reset begins at the propagated pose, upright; a stationary body keeps its pose") {
  Run run;
  const SE3<double> there(SO3<double>::exp({0.2, 0, 0.5}), {1, 2, 3});
  run.body.estimate.covariance *= 0.01;
  run.body.frames.x.T_world_body = there;
  run.pose.mark_lost(run.body);
  run.body.motion.stationary = GENERATE(false, true);
  run.pose.reset(run.body);
  CHECK(run.body.estimate.resets == 0);  // the loss was counted by mark_lost
  const Vec<double, 3> up = there.rotation().inverse() * Vec<double, 3>(0, 0, 1);
  const SE3<double> tilted(upright<double>(-up), zeros<double, 3>());
  const SE3<double> T = run.pose.state_of(run.initializer, tilted, {}).T_world_body;
  CHECK((T.p() - there.p()).norm() < 1e-9);
  CHECK((T.rotation().matrix() - there.rotation().matrix()).norm() < 1e-9);
}

TEST_CASE("dead_reckoned_pose: IMU-only propagation beyond the time limit is a loss, counted once") {
  Run run;
  REQUIRE(run.publishes(1, 0.1));
  run.advance(run.body.options.recovery.max_imu_only_s + 1);
  for (int k = 0; k < 2; ++k) {
    run.pose.reset(run.body);
    CHECK(run.body.estimate.resets == 1);
  }
}

TEST_CASE("dead_reckoned_pose: a rejected initialization leaves neither its biases nor its path") {
  Run run;
  set_zero(run.body.estimate.covariance);
  run.body.frames.x.bias_accel = bias_accel;
  run.body.frames.x.bias_gyro = bias_gyro;
  run.pose.set_initialized(run.body, run.initializer);
  run.body.motion.initialized = true;
  run.body.frames.x.bias_accel = {5, 5, 5};
  run.body.estimate.T_world_body = SE3<double>({}, {3, 0, 0});
  run.body.estimate.t_ns = 4'000'000'000;
  run.pose.discard_path(run.body, 0, 0.02);
  CHECK(run.body.frames.x.bias_accel == bias_accel);
  CHECK(run.body.sigma(3) == Approx(5));  // 3 m made, 4 s at 1 m/s
  CHECK(run.body.sigma(2) == Approx(0.08));
}

TEST_CASE("dead_reckoned_pose: a camera alone is reset at its last pose") {
  Body body;
  HoldLastPose<Body, Initializer> pose(body.options);
  body.estimate.T_world_body = SE3<double>({}, {1, 2, 3});
  body.estimate.covariance *= 0.25;
  pose.mark_lost(body);
  CHECK(body.world_uncertainty.at(body.estimate.T_world_body) == body.estimate.covariance);
}
