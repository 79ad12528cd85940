#include "plumbline/testing/trajectory.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"

using namespace plumbline;
using namespace plumbline::testing;

TEST_CASE("trajectory: velocity, rate and acceleration are the derivatives of the pose") {
  std::vector<Trajectory> trajectories{Trajectory::shaken(7)};
  for (const std::string_view scene : testing::scene_names) trajectories.push_back(*Trajectory::for_scene(scene, 7));
  for (const Trajectory& trajectory : trajectories) {
    for (double t = 0.5; t < 25; t += 0.173) {
      const double h = 5e-5;
      const MotionState before = trajectory.at(t - h), now = trajectory.at(t), after = trajectory.at(t + h);
      const Vec<double, 3> v = (after.T_world_body.p() - before.T_world_body.p()) / (2 * h);
      const Vec<double, 3> a = (after.v_world_body - before.v_world_body) / (2 * h);
      const Vec<double, 3> w = minus(after.T_world_body.rotation(), before.T_world_body.rotation()) / (2 * h);
      REQUIRE((v - now.v_world_body).norm() < 1e-6);
      REQUIRE((a - now.a_world_body).norm() < 1e-5);
      REQUIRE((w - now.w_body).norm() < 1e-6);
    }
  }
}

TEST_CASE("trajectory: shaken by hand from the first instant on, in free space") {
  const Scene scene = *make_scene("room");
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Trajectory trajectory = Trajectory::shaken(seed);
    double fastest_turn = 0, hardest = 0, first = 0;
    for (double t = 0; t < 6; t += 0.01) {
      const MotionState state = trajectory.at(t);
      fastest_turn = std::max(fastest_turn, state.w_body.norm());
      hardest = std::max(hardest, state.a_world_body.norm());
      if (t < 0.2) first = std::max(first, state.a_world_body.norm());
      REQUIRE(scene.distance(state.T_world_body.p()) > 0.5);
    }
    CAPTURE(seed, fastest_turn, hardest, first);
    REQUIRE((fastest_turn > 3 && fastest_turn < 6));
    REQUIRE((hardest > 8 && hardest < 20));
    REQUIRE(first > 4);
  }
}

TEST_CASE("trajectory: is stationary for a second, then moves like a hand-held camera") {
  for (const std::string_view scene : testing::scene_names) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Trajectory trajectory = *Trajectory::for_scene(scene, seed);
      REQUIRE(trajectory.at(0).T_world_body.p() == trajectory.at(1.0).T_world_body.p());
      REQUIRE(trajectory.at(1.0).specific_force().norm() == Approx(9.81));
      REQUIRE(trajectory.at(1.0).w_body.norm() == 0);
      double distance = 0, fastest = 0, fastest_turn = 0;
      for (double t = 0; t < 30; t += 0.01) {
        const MotionState state = trajectory.at(t);
        distance += 0.01 * state.v_world_body.norm();
        fastest = std::max(fastest, state.v_world_body.norm());
        fastest_turn = std::max(fastest_turn, state.w_body.norm());
      }
      REQUIRE(distance / 30 > 0.3);
      REQUIRE(fastest < 1.3);
      REQUIRE(fastest_turn < 1.4);
    }
  }
}

TEST_CASE("trajectory: keeps clear of the furniture and sees surfaces at a useful depth") {
  for (const std::string_view name : testing::scene_names) {
    const Scene scene = *make_scene(name);
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Trajectory trajectory = *Trajectory::for_scene(name, seed);
      for (double t = 0; t < 30; t += 0.25) {
        const SE3<double> T_world_cam = trajectory.at(t).T_world_body * simulated_T_body_camera();
        REQUIRE(scene.distance(T_world_cam.p()) > 0.5);
        const double depth = scene.intersect(T_world_cam.p(), T_world_cam.rotation() * Vec<double, 3>(0, 0, 1));
        REQUIRE(depth > 0.7);
        REQUIRE(depth < (name == "hall" || name == "ring" || name == "doors" ? 20.0 : 6.0));
      }
    }
  }
}

TEST_CASE("trajectory: the corridor's path returns to its start") {
  const Trajectory trajectory = *Trajectory::for_scene("corridor");
  const Vec<double, 3> start = trajectory.at(1).T_world_body.p(), half = trajectory.at(10.5).T_world_body.p();
  REQUIRE((half - start).norm() > 4);
  REQUIRE((trajectory.at(19.5).T_world_body.p() - start).norm() < 0.3);
}

TEST_CASE("trajectory: three laps return to the same places with another sway") {
  for (const std::string_view name : testing::scene_names) {
    for (const std::uint64_t seed : {1, 2, 3}) {
      const Trajectory trajectory = *Trajectory::for_scene(name, seed);
      const double lap_s = trajectory.lap_s(), begin = trajectory.end_of_lap_s(0) + 4, end = trajectory.end_of_lap_s(1);
      for (double t = begin; t < end; t += 0.5) {
        const MotionState first = trajectory.at(t);
        for (const int lap : {1, 2}) {
          const MotionState again = trajectory.at(t + lap * lap_s);
          const double away = (again.T_world_body.p() - first.T_world_body.p()).norm();
          const double turned = minus(again.T_world_body.rotation(), first.T_world_body.rotation()).norm();
          CAPTURE(name, seed, t, lap, away, turned);
          REQUIRE((away > 1e-3 && away < (name == "walk" ? 1.2 : name == "hall" ? 0.9 : 0.6)));
          REQUIRE(turned < 1.3);
        }
      }
    }
  }
}

TEST_CASE("trajectory: the ring walks about 1.2 m/s on a center line of 50 m, at another place for each seed") {
  REQUIRE(RingPath::lap == 50);
  for (double q = -10; q < 60; q += 0.37) {  // closed, (1) and (2)
    const RingPath a = RingPath::at({q, 1, 0}), b = RingPath::at({q + RingPath::lap, 1, 0});
    REQUIRE(std::hypot(a.x.value - b.x.value, a.y.value - b.y.value) < 1e-9);
    REQUIRE(b.heading.value - a.heading.value == Approx(2 * std::numbers::pi));
    const double speed = std::hypot(a.x.d1, a.y.d1);
    REQUIRE((speed > 0.707 && speed < 1 + 1e-9));
    REQUIRE(a.x.d1 * std::cos(a.heading.value) + a.y.d1 * std::sin(a.heading.value) > 0.95 * speed);
  }
  double path = 0;
  const Trajectory trajectory = *Trajectory::for_scene("ring", 1);
  const double begin = trajectory.end_of_lap_s(0) + 2, dt = 0.01;
  for (double t = begin; t < begin + trajectory.lap_s(); t += dt) path += dt * trajectory.at(t).v_world_body.norm();
  REQUIRE((path > 46 && path < 52));
  REQUIRE(trajectory.lap_s() == Approx(50 / 1.2));
  const Vec<double, 3> other = Trajectory::for_scene("ring", 2)->at(0).T_world_body.p();
  REQUIRE((trajectory.at(0).T_world_body.p() - other).norm() > 1);
}

TEST_CASE("trajectory: a walk by hand swings and trembles at 1 to 3 Hz, at 0.4 to 1.2 m/s") {
  for (const std::uint64_t seed : {1, 2, 3}) {
    const Trajectory trajectory = *Trajectory::for_scene("walk", seed);
    double slowest = 10, fastest = 0, squared = 0;
    int samples = 0, reversals = 0;
    double before = 0;
    for (double t = 3; t < 30; t += 0.01, ++samples) {
      const MotionState state = trajectory.at(t);
      const double speed = state.v_world_body.head<2>().norm(), rise = state.v_world_body.z();
      slowest = std::min(slowest, speed), fastest = std::max(fastest, speed);
      squared += state.a_world_body.squaredNorm();
      reversals += rise * before < 0;
      before = rise;
    }
    CAPTURE(seed, slowest, fastest, reversals);
    REQUIRE((slowest > 0.35 && slowest < 0.6));
    REQUIRE((fastest > 1.0 && fastest < 1.25));
    REQUIRE((std::sqrt(squared / samples) > 0.8 && std::sqrt(squared / samples) < 1.6));  // [m/s^2]
    REQUIRE((reversals / 27.0 > 2 && reversals / 27.0 < 6));                              // twice for each step
  }
}

TEST_CASE("trajectory: a stop on the way") {
  Trajectory trajectory = *Trajectory::for_scene("room");
  const MotionState before = trajectory.at(4);
  trajectory.stop(5, 9);
  REQUIRE(trajectory.at(4).T_world_body.p() == before.T_world_body.p());
  REQUIRE(trajectory.at(6.0).v_world_body.norm() < 1e-9);
  REQUIRE(trajectory.at(6.0).T_world_body.p().isApprox(trajectory.at(9).T_world_body.p(), 1e-12));
  REQUIRE(trajectory.at(10.5).v_world_body.norm() > 0.2);
}

TEST_CASE("trajectory: unknown scenes have none") { REQUIRE(!Trajectory::for_scene("nowhere")); }
