#include "plumbline/propagation/keyframe_increment.hpp"

#include "catch.hpp"

using namespace plumbline;

namespace {
const ImuNoise noise{.gyro_density = 1e-3, .accel_density = 1e-2, .gyro_walk = 1e-5, .accel_walk = 1e-4};
Preintegration<double> samples(double s) {
  Preintegration<double> out(noise);
  const Vec<double, 3> gyro(0, 0, 0.1), accel(0, 0, 9.81);
  if (s > 0) out.add({s, gyro, gyro, accel, accel});
  return out;
}
}  // namespace

TEST_CASE("keyframe_increment: samples of the frames since the keyframe, or of the last frame alone") {
  KeyframeIncrement<double> increment(samples(0));
  increment.append(samples(0.05), false);
  increment.append(samples(0.1), false);
  CHECK(increment.duration_s() == Approx(0.15));
  increment.keep_last(samples(0.1));
  CHECK(increment.duration_s() == Approx(0.1));
  increment.restart(samples(0));
  CHECK(increment.increment().empty());
}

TEST_CASE("keyframe_increment: it is suspect until the next keyframe") {
  KeyframeIncrement<double> increment(samples(0));
  CHECK_FALSE(increment.is_suspect());
  increment.append(samples(0.05), true);
  increment.append(samples(0.05), false);
  CHECK((increment.is_suspect() && !increment.has_jumped()));
  increment.restart(samples(0));
  CHECK_FALSE(increment.is_suspect());
  increment.mark_jumped();
  CHECK((increment.is_suspect() && increment.has_jumped()));
  increment.restart(samples(0));
  CHECK_FALSE(increment.has_jumped());
}

TEST_CASE("keyframe_increment: a distrusted accelerometer has noise, and leaves the velocity to the images") {
  KeyframeIncrement<double> increment(samples(0));
  increment.append(samples(0.1), false);
  NavState<double> before, solved;
  before.v_world_body = {1, 0, 0};
  solved.T_world_body = SE3<double>({}, {0.2, 0, 0});
  solved.v_world_body = {5, 0, 0};
  CHECK_FALSE(increment.correct(before, solved, 0.1, 20));
  CHECK(solved.v_world_body.x() == 5);

  const double variance = increment.increment().increment().covariance(6, 6);
  increment.distrust_accelerometer(20);
  CHECK(increment.increment().increment().covariance(6, 6) > 100 * variance);
  CHECK(increment.correct(before, solved, 0.1, 20));
  CHECK(solved.v_world_body.x() == Approx(2));  // 0.2 m in 0.1 s
  CHECK(increment.correct(before, solved, 0.1, 3));
  CHECK(solved.v_world_body.x() == Approx(1 + 0.3));  // no more than the limit allows
}
