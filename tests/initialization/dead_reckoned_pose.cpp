#include "plumbline/initialization/dead_reckoned_pose.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/estimator/recovery_options.hpp"
#include "plumbline/imu/preintegration.hpp"
#include "plumbline/propagation/inertial_options.hpp"
#include "plumbline/state/navigation.hpp"

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

using State = NavState<double>;

struct Options {
  RecoveryOptions recovery;
  InertialOptions propagation;
};
struct FixedPropagation {
  Samples samples;
  bool initialized = false;
  bool is_initialized() const { return initialized; }
  const Samples& imu() const { return samples; }
};
struct Window {
  State x;
  const State& latest() const { return x; }
  void set_latest(const State& state) { x = state; }
  int oldest() const { return 0; }
  const SE3<double>& T_world_body(int) const { return x.T_world_body; }
};

/// Poses of estimated scale.
struct Initializer {
  static constexpr bool needs_second_view = true;
  double sigma = 0.1;
  Vec<double, 3> velocity = Vec<double, 3>(0.5, 0, 0);
  double scale_sigma() const { return sigma; }
  double gravity_sigma() const { return 0.02; }
  Vec<double, 3> latest_velocity() const { return velocity; }
  State state_of(const SE3<double>& T_ref_rotated, const SE3<double>&) const { return {T_ref_rotated}; }
};

struct Run {
  Options options;
  FixedPropagation propagation;
  Window window;
  Initializer initializer;
  Navigation<double, InertialLayout> navigation{WorldFrameUncertainty<double>(0, true)};
  DeadReckonedPose<double> pose{options};

  void advance(double s) {
    for (double t = 0; t < s - dt / 2; t += dt) pose.advance(propagation, dt);
    pose.apply(navigation);
  }
  bool applies(double x, double scale_sigma) {
    initializer.sigma = scale_sigma;
    return pose.apply_up_to_scale(initializer, SE3<double>({}, {x, 0, 0}), {}, navigation);
  }
  double x() const { return navigation.T_world_body().p().x(); }
  double sigma(int k) const { return std::sqrt(navigation.covariance()(k, k)); }
};

}  // namespace

TEST_CASE("dead_reckoned_pose: there is none before the first known pose") {
  Run run;
  run.advance(1);
  CHECK(run.navigation.T_world_body().p().isZero());
  CHECK(run.navigation.covariance() == identity<double, 6>());
}

TEST_CASE("dead_reckoned_pose: propagates an up-to-scale pose by the IMU until a better one is found") {
  Run run;
  REQUIRE(run.applies(1, 0.1));
  CHECK(run.sigma(3) == Approx(0.1 + run.options.propagation.stationary_position_sigma));
  CHECK(run.sigma(0) == Approx(0.02));
  CHECK(run.navigation.state().v_world_body.x() == 0.5);
  run.initializer.velocity = {0, 0, 0};
  run.advance(1);
  CHECK(run.x() == Approx(1.5).epsilon(1e-3));
  CHECK(run.sigma(3) > 0.15);
  CHECK(run.applies(1.6, 0.05));
  CHECK(run.x() == 1.6);
}

TEST_CASE("dead_reckoned_pose: an up-to-scale pose outside the gate, or less certain, is not taken") {
  Run run;
  REQUIRE(run.applies(1, 0.1));
  run.advance(0.5);
  CHECK_FALSE(run.applies(3, 0.02));
  CHECK_FALSE(run.applies(1.2, 0.5));
  CHECK(run.x() == Approx(1.25).epsilon(1e-3));
  CHECK(run.applies(1.2, 0.1));
}

TEST_CASE("dead_reckoned_pose: propagates from a stationary pose, from up-to-scale poses only after the time limit") {
  Run run;
  run.pose.apply_stationary({{}, zeros<double, 3>(), stationary_bias_gyro, zeros<double, 3>()}, 0.2, run.window,
                            run.navigation);
  CHECK(run.sigma(3) == Approx(run.options.propagation.stationary_position_sigma));
  CHECK(run.window.x.bias_gyro == stationary_bias_gyro);
  run.advance(1);
  REQUIRE(run.applies(0.2, 0.5));
  run.advance(dt);
  CHECK(run.navigation.T_world_body().p().isZero(1e-9));
  run.advance(2.5);
  REQUIRE(run.applies(0.2, 0.5));
  run.advance(dt);
  CHECK(run.x() > 0.2);
}

TEST_CASE("dead_reckoned_pose: a reset begins at the propagated pose, upright; a stationary body keeps its pose") {
  Run run;
  const SE3<double> there(SO3<double>::exp({0.2, 0, 0.5}), {1, 2, 3});
  run.navigation.set_covariance(0.01 * identity<double, 6>());
  run.window.x.T_world_body = there;
  run.pose.mark_lost(run.window.x, run.navigation);
  CHECK_FALSE(run.pose.reset(GENERATE(false, true), run.navigation));  // the loss was counted by mark_lost
  const Vec<double, 3> up = there.rotation().inverse() * Vec<double, 3>(0, 0, 1);
  const SE3<double> tilted(upright<double>(-up), zeros<double, 3>());
  const SE3<double> T = run.pose.state_of(run.initializer, tilted, {}).T_world_body;
  CHECK((T.p() - there.p()).norm() < 1e-9);
  CHECK((T.rotation().matrix() - there.rotation().matrix()).norm() < 1e-9);
}

TEST_CASE("dead_reckoned_pose: IMU-only propagation beyond the time limit is a loss, counted once") {
  Run run;
  REQUIRE(run.applies(1, 0.1));
  run.advance(run.options.recovery.max_imu_only_s + 1);
  CHECK(run.pose.reset(/*is_stationary=*/false, run.navigation));
  CHECK_FALSE(run.pose.reset(/*is_stationary=*/false, run.navigation));
}

TEST_CASE("dead_reckoned_pose: a rejected initialization leaves neither its biases nor its path") {
  Run run;
  run.window.x.bias_accel = bias_accel;
  run.window.x.bias_gyro = bias_gyro;
  run.pose.set_initialized(run.window, run.initializer, run.navigation);
  run.window.x.bias_accel = {5, 5, 5};
  run.navigation.set_pose(SE3<double>({}, {3, 0, 0}));
  run.navigation.set_covariance(zeros<double, 6, 6>());
  run.navigation.set_time(4'000'000'000);
  run.pose.discard_path(run.window, run.navigation, 0, 0.02);
  CHECK(run.window.x.bias_accel == bias_accel);
  CHECK(run.sigma(3) == Approx(5));  // 3 m from the initial pose, 4 s at 1 m/s
  CHECK(run.sigma(2) == Approx(0.08));
}
