#include "plumbline/estimator/reckoned_place.hpp"

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
const Vec<double, 3> rest_bias_gyro(0, 0, 1e-3), bias_gyro(0.01, -0.02, 0.03), bias_accel(0.1, 0, -0.1);

/// The readings of a frame, whose body moves evenly and does not turn.
struct Readings {
  bool is_blind = false;
  Preintegration<double> since_frame() const {
    Preintegration<double> readings(
        ImuNoise{.gyro_density = 1e-4, .accel_density = 1e-3, .gyro_walk = 1e-6, .accel_walk = 1e-5});
    const Vec<double, 3> gyro(0, 0, 0), accel(0, 0, standard_gravity<double>);
    readings.add({dt, gyro, gyro, accel, accel});
    return readings;
  }
  bool blind() const { return is_blind; }
  bool missing() const { return false; }
};

/// What a place asks of an odometry.
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
    Readings readings;
    bool metric = false, stands = false;
    bool is_metric() const { return metric; }
    bool at_rest() const { return stands; }
    const Readings& imu() const { return readings; }
    State state_at_rest() const { return {{}, zeros<double, 3>(), rest_bias_gyro, zeros<double, 3>()}; }
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
  Origin<double> origin{0, true};
  Window frames;

  Window& window() { return frames; }
  const Window& window() const { return frames; }
  void publish(const Covariance& P) { estimate.covariance = P; }
  void set_health(HealthState state, HealthReason reason) { estimate.health = {state, reason}; }
  double sigma(int k) const { return std::sqrt(estimate.covariance(k, k)); }
};

/// Poses whose scale was found.
struct Start {
  static constexpr bool needs_second_view = true;
  double sigma = 0.1;
  Vec<double, 3> velocity = Vec<double, 3>(0.5, 0, 0);
  double scale_sigma() const { return sigma; }
  double gravity_sigma() const { return 0.02; }
  Vec<double, 3> latest_velocity() const { return velocity; }
  NavState<double> state_of(const SE3<double>& T_ref_turned, const SE3<double>&) const { return {T_ref_turned}; }
};

struct Run {
  test::SmallView<Body::Sensors> small_view;
  Body body;
  Start start;
  ReckonedPlace<Body, Start> place{body.options};

  void advance(double s) {
    const View<Body::Sensors> view = small_view.at(0, dt, {}, {});
    for (double t = 0; t < s - dt / 2; t += dt) place.advance(body, view);
    place.publish(body);
  }
  bool shows(double x, double scale_sigma) {
    body.set_health(HealthState::initializing, HealthReason::aligning);
    start.sigma = scale_sigma;
    body.frames.x.T_world_body = SE3<double>({}, {x, 0, 0});
    place.publish_rough(body, start);
    return body.estimate.health.reason == HealthReason::scale_uncertain;
  }
};

}  // namespace

TEST_CASE("reckoned_place: nothing is published before anything is known") {
  Run run;
  run.advance(1);
  CHECK(run.body.estimate.T_world_body.p().isZero());
  CHECK(run.body.estimate.covariance == identity<double, 6>());
}

TEST_CASE("reckoned_place: from a rough pose readings lead on, and a better one takes over") {
  Run run;
  REQUIRE(run.shows(1, 0.1));
  CHECK(run.body.sigma(3) == Approx(0.1 + run.body.options.motion.rest_position_sigma));
  CHECK(run.body.sigma(0) == Approx(0.02));
  CHECK(run.body.estimate.v_world_body.x() == 0.5);
  run.start.velocity = {0, 0, 0};
  run.advance(1);
  CHECK(run.body.estimate.T_world_body.p().x() == Approx(1.5).epsilon(1e-3));
  const double known = run.body.sigma(3);
  CHECK(known > 0.15);
  CHECK(run.shows(1.6, 0.05));
  CHECK(run.body.estimate.T_world_body.p().x() == 1.6);
}

TEST_CASE("reckoned_place: a rough pose that readings exclude, or that knows less, is not published") {
  Run run;
  REQUIRE(run.shows(1, 0.1));
  run.advance(0.5);
  CHECK_FALSE(run.shows(3, 0.02));
  CHECK_FALSE(run.shows(1.2, 0.5));
  CHECK(run.body.estimate.T_world_body.p().x() == Approx(1.25).epsilon(1e-3));
  CHECK(run.shows(1.2, 0.1));
}

TEST_CASE("reckoned_place: a rest is led on from, rough poses after it are not until it is too long ago") {
  Run run;
  run.place.publish_rest(run.body, 0.2);
  CHECK(run.body.estimate.health.reason == HealthReason::aligning);
  CHECK(run.body.sigma(3) == Approx(run.body.options.motion.rest_position_sigma));
  CHECK(run.body.frames.x.bias_gyro == rest_bias_gyro);
  run.advance(1);
  REQUIRE(run.shows(0.2, 0.5));
  run.advance(dt);
  CHECK(run.body.estimate.T_world_body.p().isZero(1e-9));
  run.advance(2.5);
  REQUIRE(run.shows(0.2, 0.5));
  run.advance(dt);
  CHECK(run.body.estimate.T_world_body.p().x() > 0.2);
}

TEST_CASE("reckoned_place: all begins anew where readings lead, upright; a body that stands stays where it stood") {
  Run run;
  const SE3<double> there(SO3<double>::exp({0.2, 0, 0.5}), {1, 2, 3});
  run.body.estimate.covariance *= 0.01;
  run.body.frames.x.T_world_body = there;
  run.place.lose(run.body);
  run.body.motion.stands = GENERATE(false, true);
  run.place.begin_anew(run.body);
  CHECK(run.body.estimate.resets == 0);  // whoever lost it has counted
  const Vec<double, 3> up = there.rotation().inverse() * Vec<double, 3>(0, 0, 1);
  const SE3<double> tilted(upright<double>(-up), zeros<double, 3>());
  const SE3<double> T = run.place.state_of(run.start, tilted, {}).T_world_body;
  CHECK((T.p() - there.p()).norm() < 1e-9);
  CHECK((T.rotation().matrix() - there.rotation().matrix()).norm() < 1e-9);
}

TEST_CASE("reckoned_place: readings that tell for too long are a loss, counted once") {
  Run run;
  REQUIRE(run.shows(1, 0.1));
  run.advance(run.body.options.recovery.max_coasting_s + 1);
  for (int k = 0; k < 2; ++k) {
    run.place.begin_anew(run.body);
    CHECK(run.body.estimate.resets == 1);
  }
}

TEST_CASE("reckoned_place: a wrong map leaves neither its biases nor where it led") {
  Run run;
  set_zero(run.body.estimate.covariance);
  run.body.frames.x.bias_accel = bias_accel;
  run.body.frames.x.bias_gyro = bias_gyro;
  run.place.become_metric(run.body, run.start);
  run.body.motion.metric = true;
  run.body.frames.x.bias_accel = {5, 5, 5};
  run.body.estimate.T_world_body = SE3<double>({}, {3, 0, 0});
  run.body.estimate.t_ns = 4'000'000'000;
  run.place.forget_way(run.body, 0, 0.02);
  CHECK(run.body.frames.x.bias_accel == bias_accel);
  CHECK(run.body.sigma(3) == Approx(5));  // 3 m made, 4 s at 1 m/s
  CHECK(run.body.sigma(2) == Approx(0.08));
}

TEST_CASE("reckoned_place: a camera alone begins anew where it was last seen") {
  Body body;
  HeldPlace<Body, Start> place(body.options);
  body.estimate.T_world_body = SE3<double>({}, {1, 2, 3});
  body.estimate.covariance *= 0.25;
  place.lose(body);
  CHECK(body.origin.at(body.estimate.T_world_body) == body.estimate.covariance);
}
