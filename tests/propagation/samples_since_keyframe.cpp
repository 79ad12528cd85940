#include "plumbline/propagation/samples_since_keyframe.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;

namespace {
ImuIntervals<double> samples(double s) {
  ImuIntervals<double> out;
  const Vec<double, 3> gyro(0, 0, 0.1), accel(0, 0, 9.81);
  out.add({s, gyro, gyro, accel, accel});
  return out;
}
}  // namespace

TEST_CASE("samples_since_keyframe: samples of the frames since the keyframe, or of the last frame alone") {
  SamplesSinceKeyframe<double> since_keyframe;
  since_keyframe.append(samples(0.05), false);
  since_keyframe.append(samples(0.1), false);
  CHECK(since_keyframe.duration_s() == Approx(0.15));
  since_keyframe.keep_last(samples(0.1));
  CHECK(since_keyframe.duration_s() == Approx(0.1));
  since_keyframe.restart();
  CHECK(since_keyframe.intervals().empty());
}

TEST_CASE("samples_since_keyframe: it is suspect until the next keyframe") {
  SamplesSinceKeyframe<double> since_keyframe;
  CHECK_FALSE(since_keyframe.is_suspect());
  since_keyframe.append(samples(0.05), true);
  since_keyframe.append(samples(0.05), false);
  CHECK((since_keyframe.is_suspect() && !since_keyframe.has_jumped()));
  since_keyframe.restart();
  CHECK_FALSE(since_keyframe.is_suspect());
  since_keyframe.mark_jumped();
  CHECK((since_keyframe.is_suspect() && since_keyframe.has_jumped()));
  since_keyframe.restart();
  CHECK_FALSE(since_keyframe.has_jumped());
}

TEST_CASE("samples_since_keyframe: a distrusted accelerometer has noise, and leaves the velocity to the images") {
  SamplesSinceKeyframe<double> since_keyframe;
  since_keyframe.append(samples(0.1), false);
  NavState<double> before, solved;
  before.v_world_body = {1, 0, 0};
  solved.T_world_body = SE3<double>({}, {0.2, 0, 0});
  solved.v_world_body = {5, 0, 0};
  CHECK_FALSE(since_keyframe.correct(before, solved, 0.1, 20));
  CHECK(solved.v_world_body.x() == 5);

  REQUIRE(since_keyframe.intervals().size() == 1);
  CHECK(since_keyframe.intervals()[0].accel_sigma.norm() == 0);
  since_keyframe.distrust_accelerometer(20);
  CHECK(since_keyframe.intervals()[0].accel_sigma.x() * std::sqrt(0.1) == Approx(20));  // of the mean over one second
  CHECK(since_keyframe.correct(before, solved, 0.1, 20));
  CHECK(solved.v_world_body.x() == Approx(2));  // 0.2 m in 0.1 s
  CHECK(since_keyframe.correct(before, solved, 0.1, 3));
  CHECK(solved.v_world_body.x() == Approx(1 + 0.3));  // no more than the limit allows
}
