// Motion of a camera alone.
#include "plumbline/propagation/constant_velocity.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rig.hpp"
#include "propagation/small_view.hpp"

using namespace plumbline;

namespace {

template <class S>
struct Moving {
  using Sensors = Rig<Mono<Pinhole<S>, 64 * 64>>;
  static constexpr double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-12;

  test::SmallView<Sensors> views;
  ConstantVelocity<Sensors> propagation{views.rig, {}};
  SE3<S> T_body_cam;  // the camera is the body
  PoseState<S> latest{SE3<S>(SO3<S>::exp({S(0.2), S(-0.1), S(0.4)}), Vec<S, 3>(1, 2, 3))};
  Vec<S, 6> velocity;

  Moving() { velocity << S(0.4), S(-0.2), S(0.1), S(0.5), S(-1), S(0.3); }

  View<Sensors> view(S dt) const { return views.at(0, dt, latest.T_world_body, T_body_cam); }
  /// One frame at the true place.
  void see_next(S dt) {
    const SE3<S> T = plus(latest.T_world_body, Vec<S, 6>(dt * velocity));
    latest = propagation.update(latest, T, Mat<S, 6, 6>::Identity(), view(dt));
  }
  SE3<S> predict(S dt, const test::SeenRotation<S>& seen = {}) {
    return propagation.predict(latest, view(dt), dt, [&](const SE3<S>&) { return seen; }).state.T_world_body;
  }
};

static_assert(std::is_empty_v<NoFactors> && !NoFactors::active());

}  // namespace

TEMPLATE_TEST_CASE("constant_velocity: the velocity is kept, however long the next interval", "", float, double) {
  using S = TestType;
  Moving<S> moving;
  CHECK(minus(moving.predict(S(0.05)), moving.latest.T_world_body).norm() == 0);  // nothing is known yet
  moving.see_next(S(0.05));
  for (const double dt : {0.02, 0.05, 0.2}) {
    const Vec<S, 6> d = minus(moving.predict(S(dt)), moving.latest.T_world_body);
    CHECK(double((d - S(dt) * moving.velocity).norm()) < Moving<S>::tolerance);
    CHECK(double((moving.propagation.angular_rate() - moving.velocity.template head<3>()).norm()) <
          100 * Moving<S>::tolerance);
    CHECK(double((moving.propagation.velocity(moving.latest) - moving.velocity.template tail<3>()).norm()) <
          100 * Moving<S>::tolerance);
  }
}

TEMPLATE_TEST_CASE("constant_velocity: long gaps are not bridged, and there is no prior after a loss", "", float,
                   double) {
  using S = TestType;
  Moving<S> moving;
  moving.see_next(S(0.05));
  const ConstantVelocityOptions options;
  CHECK(minus(moving.predict(S(options.max_prediction_s + 0.01)), moving.latest.T_world_body).norm() == 0);
  CHECK(minus(moving.predict(S(0.05)), moving.latest.T_world_body).norm() > S(0.01));
  moving.propagation.mark_lost();
  CHECK(minus(moving.predict(S(0.05)), moving.latest.T_world_body).norm() == 0);

  moving.see_next(S(0.05));
  const SE3<S> restarted = moving.propagation.restart(moving.latest).T_world_body;
  CHECK(minus(restarted, moving.latest.T_world_body).norm() == 0);
  CHECK(minus(moving.predict(S(0.05)), moving.latest.T_world_body).norm() == 0);
}

TEMPLATE_TEST_CASE("constant_velocity: the rotation of the image alignment is used instead, aligned near the guess", "",
                   float, double) {
  using S = TestType;
  Moving<S> moving;
  moving.see_next(S(0.05));
  const S dt = S(0.1);
  const SO3<S> R_cur_prev = SO3<S>::exp({S(0.1), S(0.2), S(-0.3)});
  SE3<S> guess;
  const auto see = [&](const SE3<S>& from) {
    guess = from;
    return test::SeenRotation<S>{true, R_cur_prev};
  };
  const SE3<S> T = moving.propagation.predict(moving.latest, moving.view(dt), dt, see).state.T_world_body;
  const SE3<S> expected = plus(moving.latest.T_world_body, Vec<S, 6>(dt * moving.velocity));
  const SO3<S> R_world_previous = moving.latest.T_world_body.rotation();
  CHECK(double((T.p() - expected.p()).norm()) < Moving<S>::tolerance);
  CHECK(double((T.R() - (R_world_previous * R_cur_prev.inverse()).matrix()).norm()) < Moving<S>::tolerance);
  CHECK(double(minus(guess, expected.inverse() * moving.latest.T_world_body).norm()) < Moving<S>::tolerance);
  const Vec<S, 3> turns = -R_cur_prev.log() / dt, turned_before = moving.velocity.template head<3>();
  const Vec<S, 3> now = turns + (turns - turned_before) / S(2);  // it turns ever faster
  CHECK(double((moving.propagation.angular_rate() - now).norm()) < 100 * Moving<S>::tolerance);

  // Images that fit better from the same place.
  const SE3<S> turned = moving.predict(dt, {true, R_cur_prev, false});
  CHECK(turned.p() == moving.latest.T_world_body.p());
  CHECK(turned.R() == T.R());
}

TEST_CASE("constant_velocity: has no factors, and accepts any pose of the images") {
  Moving<double> moving;
  const auto& propagation = moving.propagation;
  CHECK_FALSE(propagation.is_initialized());
  CHECK_FALSE(propagation.can_propagate());
  const auto motion_px = [] { return 3.0; };
  CHECK(propagation.confirm_keyframe(0, motion_px, true));
  CHECK_FALSE(propagation.confirm_keyframe(0, motion_px, false));
  CHECK_FALSE(propagation.correct(moving.latest, moving.latest, 0.1));
  CHECK(propagation.diagnose(NoFactors(0), 0, false) == HealthReason::none);
  const Mat<double, 6, 6> covariance = 2 * Mat<double, 6, 6>::Identity();
  CHECK(propagation.grown_covariance(covariance, 1.0) == covariance);
  const auto predicted = moving.propagation.predict(moving.latest, moving.view(0.1), 0,
                                                    [](const SE3<double>&) { return test::SeenRotation<double>{}; });
  CHECK_FALSE(predicted.prior.valid);

  NoFactors factors(0);
  factors.insert(0, 0, {});
  factors.for_each_row(0, -1, [](auto&&...) { FAIL("there is no row"); });
  CHECK(factors.cost(0) == 0);
}
