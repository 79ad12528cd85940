#include "plumbline/testing/simulated_imu.hpp"

#include <cmath>
#include <vector>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;
using namespace plumbline::testing;

TEST_CASE("simulated_imu: integrating exact measurements reproduces the motion") {
  for (const char* scene : {"room", "corridor", "ring", "tiles"}) {
    const Trajectory trajectory = *Trajectory::for_scene(scene, 4);
    SimulatedImu imu(ImuQuality::perfect(1000), 4);
    SimulatedImu::Measurement last = imu.next(trajectory);
    SO3<double> R = last.motion.T_world_body.rotation();
    Vec<double, 3> p = last.motion.T_world_body.p(), v = last.motion.v_world_body;
    while (last.t < 10) {  // midpoint rule
      const SimulatedImu::Measurement next = imu.next(trajectory);
      const double dt = next.t - last.t;
      const SO3<double> R_next = plus(R, Vec<double, 3>(dt / 2 * (last.gyro + next.gyro)));
      const Vec<double, 3> a = 0.5 * (R * last.accel + R_next * next.accel) + MotionState::gravity();
      p += dt * v + 0.5 * dt * dt * a;
      v += dt * a;
      R = R_next;
      last = next;
    }
    REQUIRE((p - last.motion.T_world_body.p()).norm() < 1e-4);
    REQUIRE((v - last.motion.v_world_body).norm() < 1e-4);
    REQUIRE(minus(R, last.motion.T_world_body.rotation()).norm() < 1e-5);
  }
}

TEST_CASE("simulated_imu: noise and bias walk have the stated densities") {
  const Trajectory trajectory = *Trajectory::for_scene("room");
  ImuQuality quality;
  quality.noise = {1e-3, 1e-2, 2e-3, 3e-2, 100};
  SimulatedImu imu(quality, 5);
  double gyro2 = 0, accel2 = 0, gyro_step2 = 0, accel_step2 = 0;
  constexpr int count = 20000;
  SimulatedImu::Measurement last = imu.next(trajectory);
  for (int i = 0; i < count; ++i) {
    const SimulatedImu::Measurement r = imu.next(trajectory);
    gyro2 += (r.gyro - r.gyro_bias - r.motion.w_body).squaredNorm() / 3;
    accel2 += (r.accel - r.accel_bias - r.motion.specific_force()).squaredNorm() / 3;
    gyro_step2 += (r.gyro_bias - last.gyro_bias).squaredNorm() / 3;
    accel_step2 += (r.accel_bias - last.accel_bias).squaredNorm() / 3;
    last = r;
  }
  REQUIRE(std::sqrt(gyro2 / count) == Approx(1e-3 * 10).epsilon(0.02));
  REQUIRE(std::sqrt(accel2 / count) == Approx(1e-2 * 10).epsilon(0.02));
  REQUIRE(std::sqrt(gyro_step2 / count) == Approx(2e-3 / 10).epsilon(0.02));
  REQUIRE(std::sqrt(accel_step2 / count) == Approx(3e-2 / 10).epsilon(0.02));
}

TEST_CASE("simulated_imu: same seed, same measurements; time stamps are exact") {
  const Trajectory trajectory = *Trajectory::for_scene("room");
  SimulatedImu a({}, 9), b({}, 9), c({}, 10);
  bool differs = false;
  for (int i = 0; i < 500; ++i) {
    const ImuSample x = a.next(trajectory).sample(1000), y = b.next(trajectory).sample(1000),
                    z = c.next(trajectory).sample(1000);
    REQUIRE(x.t_ns == 1000 + i * 5'000'000ll);
    REQUIRE((x.gyro == y.gyro && x.accel == y.accel));
    differs = differs || x.gyro != z.gyro;
  }
  REQUIRE(differs);
}
