// Motion of a rig with an IMU: prediction by IMU samples, by images where samples are missing, and IMU factors.
//                                                                                docs/math/inertial_window.md
#include "plumbline/propagation/inertial.hpp"

#include <cmath>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/state/frame_window.hpp"
#include "propagation/small_view.hpp"

using namespace plumbline;

namespace {

constexpr TimeNs period = 5'000'000, frame = 50'000'000;
constexpr double frame_s = 0.05, rate_z = 0.4;  // [rad/s]

/// A body that turns evenly about the vertical and moves evenly, or is stationary; its samples have biases.
template <class S>
struct Drive {
  using Sensors = Rig<Mono<Pinhole<S>, 64 * 64>, Imu>;
  using Propagation = Inertial<Sensors>;
  static constexpr double tolerance = std::is_same_v<S, float> ? 2e-5 : 1e-9;

  test::SmallView<Sensors> views;
  std::unique_ptr<Propagation> propagation;
  SE3<S> T_body_cam{SO3<S>::exp({S(1.2), S(-0.4), S(0.3)}), Vec<S, 3>(S(0.1), S(-0.2), S(0.05))};
  bool moves = true;
  Vec<double, 3> bias_gyro{0.01, -0.02, 0.015}, bias_accel{0, 0, 0.1};
  NavState<S> latest;  ///< of the last frame, exact
  TimeNs now = 0;

  explicit Drive(bool drives = true, const InertialOptions& options = {}) : moves(drives) {
    propagation = std::make_unique<Propagation>(views.rig, options);
    read(-300'000'000, 0);
    propagation->begin_frame(0, nullptr, 0);
    latest = truth(0);
  }

  static Mat<S, 6, 6> sure() { return S(1e-8) * Mat<S, 6, 6>::Identity(); }
  NavState<S> truth(TimeNs t_ns) const {
    const double t = moves ? 1e-9 * double(t_ns) : 0;
    NavState<double> x;
    x.T_world_body = SE3<double>(SO3<double>::exp({0, 0, rate_z * t}), Vec<double, 3>(1 + 0.6 * t, -0.2 * t, 0.5));
    if (moves) x.v_world_body = {0.6, -0.2, 0};
    x.bias_gyro = bias_gyro;
    x.bias_accel = bias_accel;
    return x.template cast<S>();
  }
  ImuSample sample_at(TimeNs t_ns) const {
    const double wiggle = 1e-9 * double(t_ns / period % 7);  // a live sensor does not repeat itself
    return {t_ns, bias_gyro + Vec<double, 3>(wiggle, 0, moves ? rate_z : 0),
            bias_accel + Vec<double, 3>(0, wiggle, 9.81)};
  }
  /// Samples in (from, to].
  void read(TimeNs from, TimeNs to, auto&& change) {
    for (TimeNs t = from + period; t <= to; t += period) {
      ImuSample sample = sample_at(t);
      change(sample);
      REQUIRE(propagation->imu().add(sample, from < 0 ? nullptr : &latest));
    }
  }
  void read(TimeNs from, TimeNs to) {
    read(from, to, [](ImuSample&) {});
  }

  bool confirm_keyframe(double moved_px, bool needed) {
    return propagation->confirm_keyframe(
        now, [&] { return moved_px; }, needed);
  }

  /// On to the next frame, without having seen its features; samples may be missing, or changed.
  void advance(bool reads = true) {
    if (reads) read(now, now + frame);
    now += frame;
    propagation->begin_frame(now, &latest, S(frame_s));
  }
  void advance_with(auto&& change) {
    read(now, now + frame, change);
    now += frame;
    propagation->begin_frame(now, &latest, S(frame_s));
  }
  View<Sensors> view() const {
    return views.at(now, S(frame_s), latest.T_world_body, propagation->T_body_cam(T_body_cam));
  }
  Prediction<NavState<S>, S> predict(const test::SeenRotation<S>& seen = {}, S outage_s = S(frame_s)) {
    return propagation->predict(latest, view(), outage_s, [&](const SE3<S>&) { return seen; });
  }
  /// The camera's rotation as the images show it.
  test::SeenRotation<S> shown() const {
    const SO3<S> R_body_cam = T_body_cam.rotation();
    return {true, (truth(now).T_world_body.rotation() * R_body_cam).inverse() *
                      (latest.T_world_body.rotation() * R_body_cam)};
  }
  /// The frame was found where it is.
  void found() { latest = truth(now); }
  void go_on(int frames) {
    for (int k = 0; k < frames; ++k) {
      advance();
      found();
    }
  }
  double error(const NavState<S>& x) const { return double(minus(x, truth(now)).norm()); }
};

template <class S>
using Window = FrameWindow<S, InertialLayout, 4>;

}  // namespace

TEMPLATE_TEST_CASE("inertial: the rate of an image is that of its own time, however fast it changes", "", float,
                   double) {
  using S = TestType;
  Drive<S> drive;
  const TimeNs image = drive.now + frame;
  drive.advance_with([&](ImuSample& sample) { sample.gyro.x() += 10 * seconds_between(image, sample.t_ns); });
  CHECK(double((drive.propagation->angular_rate() - Vec<S, 3>(0, 0, S(rate_z))).norm()) <
        1e-4);  // a mean is 0.1 beside
}

TEMPLATE_TEST_CASE("inertial: an initialized state is predicted by the IMU, with its uncertainty", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  REQUIRE(drive.propagation->can_propagate());
  for (int k = 0; k < 4; ++k) {
    drive.advance();
    const auto predicted = drive.predict();
    CHECK(drive.error(predicted.state) < Drive<S>::tolerance);
    CHECK(double((drive.propagation->angular_rate() - Vec<S, 3>(0, 0, S(rate_z))).norm()) < 1e-4);
    const Vec<S, 3> v_world = predicted.state.T_world_body.rotation() * drive.propagation->velocity(predicted.state);
    CHECK(double((v_world - predicted.state.v_world_body).norm()) < 1e-5);
    REQUIRE(predicted.prior.valid);
    const InertialOptions options;
    const auto& covariance = drive.propagation->imu().since_frame().increment().covariance;
    for (int i = 0; i < 3; ++i) {
      CHECK(double(predicted.prior.sigma[i]) ==
            Approx(std::hypot(options.rotation_sigma, std::sqrt(double(covariance(i, i))))));
      CHECK(double(predicted.prior.sigma[3 + i]) ==
            Approx(std::hypot(options.velocity_sigma * frame_s, std::sqrt(double(covariance(3 + i, 3 + i))))));
    }
    // The longer images are of no use, the less the velocity is worth.
    CHECK(drive.predict({}, S(2)).prior.sigma[3] > S(10) * predicted.prior.sigma[3]);
    CHECK(drive.predict({}, S(2)).prior.sigma[0] == predicted.prior.sigma[0]);
    // A pose from the images does not replace the state that enters the window.
    const SE3<S> elsewhere(predicted.state.T_world_body.rotation(), Vec<S, 3>::Zero());
    const NavState<S> x = drive.propagation->update(predicted.state, elsewhere, Drive<S>::sure(), drive.view());
    CHECK(drive.error(x) == Approx(drive.error(predicted.state)));
    drive.found();
  }
}

TEMPLATE_TEST_CASE("inertial: before initialization rotation is that of the gyroscope, translation that of the images",
                   "", float, double) {
  using S = TestType;
  Drive<S> drive;
  CHECK_FALSE(drive.propagation->is_initialized());
  CHECK_FALSE(drive.propagation->can_propagate());
  CHECK_FALSE(drive.propagation->is_initialized());
  drive.latest.v_world_body = {S(3), S(0), S(-1)};  // in the unit of vision
  const SE3<S> before = drive.latest.T_world_body;
  drive.advance();
  const auto predicted = drive.predict({true, SO3<S>::exp({S(1), 0, 0})});  // the rotation of the images is not used
  CHECK_FALSE(predicted.prior.valid);
  const SE3<S>& T = predicted.state.T_world_body;
  CHECK(double((T.R() - drive.truth(drive.now).T_world_body.R()).norm()) < Drive<S>::tolerance);
  CHECK(double((T.p() - before.p() - S(frame_s) * drive.latest.v_world_body).norm()) < Drive<S>::tolerance);
  // The lever arm has no length in that unit.
  CHECK(drive.view().T_body_cam.p().norm() == 0);
  CHECK((drive.view().T_body_cam.R() - drive.T_body_cam.R()).norm() == 0);
  // The pose of the features is that of the frame, and updates the velocity.
  const SE3<S> found(T.rotation(), before.p() + Vec<S, 3>(S(0.2), S(0.1), 0));
  const NavState<S> x = drive.propagation->update(predicted.state, found, Drive<S>::sure(), drive.view());
  CHECK(minus(x.T_world_body, found).norm() == 0);
  CHECK(double((S(frame_s) * x.v_world_body - Vec<S, 3>(S(0.2), S(0.1), 0)).norm()) < Drive<S>::tolerance);

  drive.propagation->set_initialized();
  CHECK(drive.propagation->is_initialized());
  CHECK(minus(drive.view().T_body_cam, drive.T_body_cam).norm() == 0);
}

TEMPLATE_TEST_CASE(
    "inertial: before initialization the shutter motion is that of three images, whose errors may alternate", "", float,
    double) {
  using S = TestType;
  Drive<S> drive;
  const Vec<S, 3> v(S(0.6), S(-0.2), 0), error(S(0.01), S(0.02), S(-0.03));
  Vec<S, 6> at = zeros<S, 6>(), before = zeros<S, 6>();
  Vec<S, 3> rate_before = zeros<S, 3>();
  for (int k = 0; k < 4; ++k) {
    rate_before = drive.propagation->angular_rate();
    drive.advance_with([&](ImuSample& sample) { sample.gyro.y() += 0.1 * k; });
    const NavState<S> predicted = drive.predict().state;
    SE3<S> T = drive.truth(drive.now).T_world_body;
    T = SE3<S>(T.rotation(), T.p() + (k % 2 == 0 ? error : Vec<S, 3>(-error)));
    at = drive.propagation->motion_at(predicted, T, drive.view());
    before = drive.propagation->motion_before(predicted, T, drive.view());
    const SO3<S> R_before = drive.latest.T_world_body.rotation();
    if (k >= 2) {  // two intervals are known: without what alternates
      CHECK(double((segment<3>(at, 3) - T.rotation().inverse() * v).norm()) < 10 * Drive<S>::tolerance);
      CHECK(double((segment<3>(before, 3) - R_before.inverse() * v).norm()) < 10 * Drive<S>::tolerance);
      CHECK((segment<3>(at, 0) - drive.propagation->angular_rate()).norm() == 0);
      CHECK((segment<3>(before, 0) - rate_before).norm() == 0);
      CHECK(double((segment<3>(at, 0) - rate_before).norm()) > 0.05);
    }
    drive.latest = drive.propagation->update(predicted, T, Drive<S>::sure(), drive.view());
  }
}

TEMPLATE_TEST_CASE("inertial: where samples are missing rotation and velocity are those of the images", "", float,
                   double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  drive.go_on(2);
  drive.propagation->begin_factor();
  drive.go_on(1);
  NavState<S> untouched = drive.latest;
  CHECK_FALSE(drive.propagation->correct(drive.latest, untouched, S(frame_s)));
  CHECK_FALSE(drive.confirm_keyframe(50, false));

  for (int k = 0; k < 2; ++k) {
    drive.advance(false);
    REQUIRE(drive.propagation->imu().is_missing());
    const auto predicted = drive.predict(drive.shown());
    CHECK(double(minus(predicted.state.T_world_body, drive.truth(drive.now).T_world_body).norm()) <
          Drive<S>::tolerance);
    CHECK(double((drive.predict().state.T_world_body.R() - drive.latest.T_world_body.R()).norm()) <
          Drive<S>::tolerance);  // nor is there an image alignment
    const NavState<S> x =
        drive.propagation->update(predicted.state, drive.truth(drive.now).T_world_body, Drive<S>::sure(), drive.view());
    CHECK(drive.error(x) < Drive<S>::tolerance);
    CHECK_FALSE(drive.confirm_keyframe(50, false));  // samples are still missing
    NavState<S> solved = x;
    solved.v_world_body.setZero();
    REQUIRE(drive.propagation->correct(drive.latest, solved, S(frame_s)));
    CHECK(double((solved.v_world_body - drive.truth(0).v_world_body).norm()) < 1e-3);
    NavState<S> jumped = x;
    jumped.T_world_body = SE3<S>(x.T_world_body.rotation(), x.T_world_body.p() + Vec<S, 3>(0, 3, 4));
    REQUIRE(drive.propagation->correct(drive.latest, jumped, S(frame_s)));
    const Vec<S, 3> change = jumped.v_world_body - drive.latest.v_world_body;
    const double most = InertialOptions().suspect_accel_sigma * frame_s;
    CHECK(double(change.norm()) == Approx(most).epsilon(1e-3));
    CHECK(double(change.dot(Vec<S, 3>(0, 3, 4))) == Approx(5 * most).epsilon(0.05));
    drive.found();
  }
  drive.go_on(1);
  CHECK(drive.confirm_keyframe(50, false));  // they are: the next factor begins at a known velocity
  drive.propagation->begin_factor();
  CHECK_FALSE(drive.confirm_keyframe(50, false));
  CHECK(drive.confirm_keyframe(50, true));
}

TEMPLATE_TEST_CASE("inertial: where one sensor is saturated the other one is still used", "", float, double) {
  using S = TestType;
  const test::SeenRotation<S> wrong{true, SO3<S>::exp({S(0.5), 0, 0})};
  Drive<S> drive;
  drive.propagation->set_initialized();
  drive.go_on(1);
  drive.advance_with([](ImuSample& sample) { sample.accel.x() = 1e3; });
  REQUIRE(drive.propagation->imu().is_unusable());
  SE3<S> T = drive.predict(wrong).state.T_world_body;  // rotation by the gyroscope
  CHECK(double(minus(T, drive.truth(drive.now).T_world_body).norm()) < Drive<S>::tolerance);
  drive.found();
  drive.advance_with([](ImuSample& sample) { sample.gyro.x() = 1e3; });
  T = drive.predict(drive.shown()).state.T_world_body;  // rotation by the images
  CHECK(double(minus(T, drive.truth(drive.now).T_world_body).norm()) < Drive<S>::tolerance);
}

TEMPLATE_TEST_CASE("inertial: a factor has all samples since its keyframe", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  drive.go_on(2);
  drive.propagation->begin_factor();
  const NavState<S> keyframe = drive.latest;
  CHECK(drive.propagation->factor(3).samples.empty());
  drive.go_on(5);
  const ImuFactor<S> factor = drive.propagation->factor(3);
  CHECK(factor.previous == 3);
  CHECK_FALSE(factor.is_stationary);
  CHECK(double(factor.samples.duration()) == Approx(5 * frame_s));
  const NavState<S> there = integrated(factor.samples, factor.noise, keyframe.bias_gyro, keyframe.bias_accel)
                                .predict(keyframe, gravity_in_world<S>());
  CHECK(drive.error(there) < 10 * Drive<S>::tolerance);
  // Densities are those of the calibration, inflated.
  const InertialOptions options;
  CHECK(factor.noise.gyro_density == Approx(options.gyro_inflation * ImuNoise{}.gyro_density));
  CHECK(factor.noise.accel_walk == Approx(options.walk_inflation * ImuNoise{}.accel_walk));
}

TEST_CASE("inertial: the error of an accelerometer beside its noise does not grow with the noise") {
  const InertialOptions options;
  const auto inflated = [&](double density) { return options.inflated({.accel_density = density}).accel_density; };
  CHECK(inflated(ImuNoise{}.accel_density) == options.accel_error);
  CHECK(inflated(1e-2) == Approx(options.min_accel_inflation * 1e-2));
  CHECK(inflated(2e-4) == Approx(options.max_accel_inflation * 2e-4));
  CHECK(inflated(0) == 0);
}

TEMPLATE_TEST_CASE("inertial: a gyroscope whose bias jumps, against the images", "", float, double) {
  using S = TestType;
  const InertialOptions options;
  Drive<S> drive;
  drive.propagation->set_initialized();
  const NavState<S> keyframe = drive.latest;
  const auto go_on = [&](double bias, S variance = S(1e-8)) {
    drive.advance_with([&](ImuSample& sample) { sample.gyro.x() += bias; });
    const auto predicted = drive.predict();
    const Mat<S, 6, 6> covariance = variance * Mat<S, 6, 6>::Identity();
    const NavState<S> x =
        drive.propagation->update(predicted.state, drive.truth(drive.now).T_world_body, covariance, drive.view());
    drive.found();
    drive.latest.bias_gyro = x.bias_gyro;
    return drive.propagation->factor(0).jumped;
  };
  for (int k = 0; k < 20; ++k) REQUIRE(!go_on(0.1, S(1e-4)));                             // uncertain image rotations
  for (int k = 0; k < 40; ++k) REQUIRE(!go_on(0.2 * options.gyro_check.max_rate_error));  // no more than any bias does
  drive.propagation->begin_factor();
  const auto excludes = [&](double sigmas) {
    const auto predicted = drive.predict();
    Vec<S, 6> d = Vec<S, 6>::Zero();
    d[1] = S(sigmas) * predicted.prior.sigma[1];
    return drive.propagation->contradicts(predicted, plus(predicted.state.T_world_body, d));
  };
  CHECK(excludes(1.1 * options.innovation_gate));
  int frames = 0, suspect = 0;
  for (; !go_on(0.1, S(3e-7)) && frames < 20; ++frames) suspect += !excludes(1.1 * options.innovation_gate);
  CHECK(frames * frame_s < options.gyro_check.rate_error_s);
  CHECK(suspect > 0);  // images that turn otherwise are heard until it is decided
  CHECK(double(drive.propagation->gyro_jump_rotation()) > 0.1 * (frames + 1) * frame_s);

  // It is detected once, in a factor that ends as soon as it can; the new bias applies from now on.
  CHECK(drive.confirm_keyframe(100, false));
  drive.propagation->begin_factor();
  CHECK_FALSE(drive.propagation->factor(0).jumped);
  CHECK(excludes(1.1 * options.innovation_gate_after_jump));
  frames = 1;
  for (; !go_on(0.1) && frames < 200; ++frames) {
    CHECK(excludes(1.1 * options.innovation_gate_after_jump));
    CHECK(drive.propagation->gyro_jump_rotation() == 0);
  }
  CHECK(frames * frame_s == Approx(options.gyro_check.jump_hold_s).margin(1.5 * frame_s));
  for (int k = 0; k < 300; ++k) go_on(0.1);
  CHECK(double(drive.latest.bias_gyro.x()) ==
        Approx(drive.bias_gyro.x() + 0.1).margin(1.2 * options.gyro_check.max_rate_error));
}

TEMPLATE_TEST_CASE("inertial: an accelerometer inconsistent with the images is not used", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  const auto go_on = [&](double error) {
    drive.advance_with([&](ImuSample& sample) { sample.accel.x() += error; });
    const auto predicted = drive.predict();
    drive.propagation->update(predicted.state, drive.truth(drive.now).T_world_body, drive.sure(), drive.view());
    const double off_m = double(norm(predicted.state.T_world_body.p() - drive.truth(drive.now).T_world_body.p()));
    drive.found();
    return off_m;
  };
  for (int k = 0; k < 80; ++k) REQUIRE(go_on(0) < 1e-4);
  CHECK_FALSE(drive.propagation->factor(0).is_accel_suspect);
  for (int k = 0; k < 20; ++k) go_on(4);
  const ImuFactor<S> factor = drive.propagation->factor(0);
  CHECK(factor.is_accel_suspect);
  const ImuIncrement<S> increment = integrated(factor.samples, factor.noise, zeros<S, 3>(), zeros<S, 3>());
  const double sigma = std::sqrt(double(increment.covariance(6, 6)));
  const double open = InertialOptions().suspect_accel_sigma * std::sqrt(double(increment.duration));
  CHECK(sigma > 0.9 * open);  // before it was found, too
  CHECK(go_on(4) < 1e-4);     // constant velocity; 5 mm by the IMU
  for (int k = 0; k < 100; ++k) go_on(0);
  CHECK_FALSE(drive.propagation->factor(0).is_accel_suspect);
  CHECK(drive.confirm_keyframe(100, false));  // the factor with the suspect part ends
}

TEMPLATE_TEST_CASE("inertial: images with few features do not make the accelerometer suspect", "", float, double) {
  using S = TestType;
  const bool few_features = GENERATE(false, true);
  CAPTURE(few_features);
  Drive<S> drive;
  drive.propagation->set_initialized();
  const auto factors = std::make_unique<ImuFactors<S, 4>>(InertialOptions());
  const auto go_on = [&](double error) {
    drive.advance_with([&](ImuSample& sample) { sample.accel.x() += error; });
    const auto predicted = drive.predict();
    drive.propagation->update(predicted.state, drive.truth(drive.now).T_world_body, drive.sure(), drive.view());
    drive.found();
    drive.propagation->diagnose(*factors, Window<S>(), few_features);
  };
  for (int k = 0; k < 80; ++k) go_on(0);
  int before_detection = 0;
  for (; before_detection < 40 && !drive.propagation->factor(0).is_accel_suspect; ++before_detection) go_on(4);
  if (few_features) {
    CHECK(before_detection == 40);
  } else {
    REQUIRE(before_detection < 20);
    // The frame of the detection is the first with a velocity of the images, and not a jump of theirs.
    NavState<S> solved = drive.latest;
    solved.v_world_body.x() += S(20);
    solved.T_world_body = SE3<S>(solved.T_world_body.rotation(), solved.T_world_body.p() + Vec<S, 3>(S(1), S(0), S(0)));
    CHECK(drive.propagation->correct(drive.latest, solved, S(frame_s)));
    const double gained = double(norm(Vec<S, 3>(solved.v_world_body - drive.latest.v_world_body)));
    CHECK(gained <= Approx(InertialOptions().suspect_accel_sigma * frame_s));
  }
}

TEMPLATE_TEST_CASE("inertial: where both sensors seem to fail at once the images are suspect", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  const auto go_on = [&](double gyro_error, double accel_error) {
    drive.advance_with([&](ImuSample& sample) {
      sample.gyro.x() += gyro_error;
      sample.accel.x() += accel_error;
    });
    const auto predicted = drive.predict();
    const NavState<S> x =
        drive.propagation->update(predicted.state, drive.truth(drive.now).T_world_body, drive.sure(), drive.view());
    drive.found();
    drive.latest.bias_gyro = x.bias_gyro;
  };
  for (int k = 0; k < 80; ++k) go_on(0, 0);
  for (int k = 0; k < 20; ++k) go_on(0.1, 0);
  for (int k = 0; k < 20; ++k) go_on(0.1, 4);
  CHECK_FALSE(drive.propagation->factor(0).is_accel_suspect);
  for (int k = 0; k < 80; ++k) go_on(0.1, 0);
  for (int k = 0; k < 20; ++k) go_on(0.1, 4);
  CHECK(drive.propagation->factor(0).is_accel_suspect);
}

TEMPLATE_TEST_CASE("inertial: poses outside the gate of the IMU", "", float, double) {
  using S = TestType;
  const InertialOptions options;
  Drive<S> drive;
  drive.advance();
  const SE3<S> T = drive.truth(drive.now).T_world_body;
  CHECK_FALSE(drive.propagation->contradicts(drive.predict(), SE3<S>()));  // not metric yet
  drive.propagation->set_initialized();
  const auto predicted = drive.predict();
  CHECK_FALSE(drive.propagation->contradicts(predicted, T));
  for (int k = 0; k < 6; ++k) {
    Vec<S, 6> d = Vec<S, 6>::Zero();
    d[k] = S(0.9 * options.innovation_gate) * predicted.prior.sigma[k];
    CHECK_FALSE(drive.propagation->contradicts(predicted, plus(T, d)));
    d[k] *= S(-1.3);
    CHECK(drive.propagation->contradicts(predicted, plus(T, d)));
    CHECK(drive.propagation->passes_gate(predicted, plus(T, d)));  // the covariance of the velocity is not set
  }
  CHECK(drive.propagation->contradicts(predicted, SE3<S>(T.rotation(), Vec<S, 3>::Constant(S(NAN)))));

  // The consensus has the gate of the velocity's uncertainty, until an outage of the images.
  constexpr int dim = MovingLayout::dim, velocity = MovingLayout::offset<state::Velocity>;
  const S sigma = S(0.01), dt = S(frame_s);
  Mat<S, dim, dim> P = Mat<S, dim, dim>::Identity();
  for (int k = velocity; k < dim; ++k) P(k, k) = sigma * sigma;
  drive.propagation->set_velocity_covariance(P);
  const auto known = drive.predict();
  Vec<S, 6> d = Vec<S, 6>::Zero();
  d[4] = S(0.8 * options.consensus_gate * options.velocity_inflation) * sigma * dt;
  CHECK(drive.propagation->passes_gate(known, plus(T, d)));
  d[4] *= S(2);
  CHECK_FALSE(drive.propagation->passes_gate(known, plus(T, d)));
  CHECK_FALSE(drive.propagation->contradicts(known, plus(T, d)));
  drive.propagation->mark_lost();
  CHECK(drive.propagation->passes_gate(drive.predict(), plus(T, d)));
}

TEMPLATE_TEST_CASE("inertial: stationary only if both images and IMU are", "", float, double) {
  using S = TestType;
  const InertialOptions options;
  Drive<S> resting(false);
  resting.propagation->set_initialized();
  CHECK_FALSE(resting.propagation->detect_stationarity(resting.now, 0));  // too few samples so far
  resting.go_on(20);
  CHECK(resting.propagation->detect_stationarity(resting.now, 0.9 * options.stationary_motion_px));
  CHECK(resting.propagation->is_stationary());
  CHECK(resting.propagation->factor(0).is_stationary);
  CHECK_FALSE(resting.confirm_keyframe(0, true));  // no keyframes while stationary
  // Left less easily than entered.
  const double between = 0.5 * (1 + options.stationary_hysteresis) * options.stationary_motion_px;
  CHECK(resting.propagation->detect_stationarity(resting.now, between));
  CHECK_FALSE(resting.propagation->detect_stationarity(
      resting.now, 1.1 * options.stationary_hysteresis * options.stationary_motion_px));
  CHECK_FALSE(resting.propagation->detect_stationarity(resting.now, between));
  CHECK(resting.propagation->detect_stationarity(resting.now, 0));
  const NavState<S> x = resting.propagation->stationary_state();
  CHECK(double((x.bias_gyro.template cast<double>() - resting.bias_gyro).norm()) < 1e-5);
  CHECK(double((x.bias_accel.template cast<double>() - resting.bias_accel).norm()) < 1e-4);
  CHECK(double((x.T_world_body.R() - Mat<S, 3, 3>::Identity()).norm()) < 1e-3);
  resting.propagation->mark_lost();
  resting.go_on(1);
  CHECK(resting.propagation->is_stationary());  // without images, as long as the IMU is stationary

  // Even motion in a straight line looks the same to an IMU, an even turn does not.
  Drive<S> turning;
  turning.go_on(20);
  CHECK_FALSE(turning.propagation->detect_stationarity(turning.now, 0));
}

TEMPLATE_TEST_CASE("inertial: without images the covariance grows by IMU noise and velocity", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  drive.go_on(1);
  drive.advance();
  const Mat<S, 6, 6> before = S(1e-4) * Mat<S, 6, 6>::Identity();
  const InertialOptions options;
  const double walk = options.velocity_sigma * options.velocity_sigma * frame_s;
  const auto& covariance = drive.propagation->imu().since_frame().increment().covariance;
  const auto check_grown = [&](double outage_s, double moved) {
    const Mat<S, 6, 6> grown = drive.propagation->grown_covariance(before, S(outage_s));
    for (int r = 0; r < 6; ++r) {
      for (int c = 0; c < 6; ++c) {
        const double more = r == c && r >= 3 ? walk + moved : 0;
        CHECK(double(grown(r, c)) == Approx(double(before(r, c)) + double(covariance(r, c)) + more).margin(1e-12));
      }
    }
  };
  check_grown(1, 0);
  // What is wrong with the velocity of the last state solved for adds up, seen or not.
  const double sigma = 3;
  drive.propagation->set_speed_covariance(S(sigma * sigma) * Mat<S, MovingLayout::dim, MovingLayout::dim>::Identity(),
                                          drive.latest.v_world_body);
  drive.propagation->mark_lost();
  check_grown(1, sigma * sigma * (1 - (1 - frame_s) * (1 - frame_s)));
}

TEMPLATE_TEST_CASE("inertial: the sigma of the speed is that of the velocity along it", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  const auto sigma_at = [&](const Vec<S, 3>& v) {
    constexpr int at = MovingLayout::offset<state::Velocity>;
    Mat<S, MovingLayout::dim, MovingLayout::dim> P = Mat<S, MovingLayout::dim, MovingLayout::dim>::Identity();
    P(at, at) = S(0.01);
    drive.propagation->set_speed_covariance(P, v);
    CHECK(drive.propagation->speed() == Approx(double(v.norm())));
    return drive.propagation->speed_sigma();
  };
  CHECK(sigma_at({S(2), S(0), S(0)}) == Approx(0.1));
  CHECK(sigma_at({S(0), S(-4), S(0)}) == Approx(1));
  CHECK(sigma_at({S(3), S(0), S(4)}) == Approx(std::sqrt(0.36 * 0.01 + 0.64)));
  CHECK_FALSE(sigma_at({S(0), S(0), S(0)}) < 1e9);  // nothing moves
  drive.propagation->set_initialized();
  CHECK(drive.propagation->speed() == 0);
}

TEMPLATE_TEST_CASE("inertial: an accelerometer that gravity saturates is unusable", "", float, double) {
  using S = TestType;
  InertialOptions options;
  const auto factors = std::make_unique<ImuFactors<S, 4>>(options);
  Window<S> window;
  Drive<S> drive;
  drive.propagation->set_initialized();
  const auto clip_at = [](double full_scale) {
    return [full_scale, n = 0](ImuSample& sample) mutable {  // it comes and goes
      sample.accel.z() = ++n % 2 == 0 ? full_scale - 0.01 * n : full_scale;
    };
  };
  for (int k = 0; k < 8; ++k) drive.advance_with(clip_at(10.0));
  drive.found();
  drive.go_on(2);  // between two arrivals
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::imu_saturated);
}

TEMPLATE_TEST_CASE("inertial: diagnoses its samples", "", float, double) {
  using S = TestType;
  InertialOptions options;
  const auto factors = std::make_unique<ImuFactors<S, 4>>(options);
  Window<S> window;
  Drive<S> drive;
  drive.propagation->set_initialized();
  drive.go_on(2);
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::none);
  drive.advance_with([](ImuSample& sample) { sample.accel.x() = 1e3; });
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::imu_saturated);
  drive.found();
  drive.advance(false);
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::no_imu_data);
  drive.found();
  drive.go_on(1);
  // IMU and images that are inconsistent.
  const int first = window.insert(drive.now, drive.latest);
  factors->insert(first, drive.latest, {});
  drive.propagation->begin_factor();
  drive.go_on(2);
  NavState<S> x = drive.latest;
  const int second = window.insert(drive.now, x);
  factors->insert(second, x, drive.propagation->factor(first));
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::none);
  x.v_world_body.x() += S(2);
  window.state(second) = typename Window<S>::State(x);
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::imu_disagrees);
  CHECK(drive.propagation->is_inconsistent());
  // A saturated or missing IMU is the reason that is given, and hides no contradiction.
  drive.advance_with([](ImuSample& sample) { sample.accel.x() = 1e3; });
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::imu_saturated);
  CHECK(drive.propagation->is_inconsistent());
  drive.found();
  drive.advance(false);
  CHECK(drive.propagation->diagnose(*factors, window, false) == HealthReason::no_imu_data);
  CHECK(drive.propagation->is_inconsistent());
  x.v_world_body.x() -= S(2);
  window.state(second) = typename Window<S>::State(x);
  drive.propagation->diagnose(*factors, window, false);
  CHECK_FALSE(drive.propagation->is_inconsistent());
}

TEMPLATE_TEST_CASE("inertial: a reset keeps the biases alone", "", float, double) {
  using S = TestType;
  Drive<S> drive;
  drive.propagation->set_initialized();
  drive.go_on(1);
  const NavState<S> x = drive.propagation->restart(drive.latest);
  CHECK(minus(x.T_world_body, SE3<S>()).norm() == 0);
  CHECK(x.v_world_body.norm() == 0);
  CHECK(x.bias_gyro == drive.latest.bias_gyro);
  CHECK(x.bias_accel == drive.latest.bias_accel);
  CHECK_FALSE(drive.propagation->is_initialized());
}
