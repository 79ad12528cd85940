#include "plumbline/io/trajectory_evaluation.hpp"

#include <cmath>
#include <string>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

/// A helix at 10 Hz, seen from a world that is moved and `scale` times as large.
Trajectory helix(double from_s, double to_s, double scale = 1) {
  const Sim3<double> moved(scale, SO3<double>::exp({0, 0, scale - 1}), {scale - 1, 0, 0});
  Trajectory out;
  for (int i = static_cast<int>(std::lround(10 * from_s)); i <= std::lround(10 * to_s); ++i) {
    const double t = 0.1 * i;
    const SE3<double> pose(SO3<double>::exp({0, 0, t / 2}), {std::cos(t), std::sin(t), t / 5});
    out.push_back({i * 100'000'000LL, aligned(moved, pose)});
  }
  return out;
}

}  // namespace

TEST_CASE("trajectory_evaluation: the same motion in another world has no error") {
  const Evaluation e = evaluate_trajectory(helix(0, 9.9), helix(0, 9.9, 2), {.alignment = Alignment::sim3});
  REQUIRE((e.pairs == 100 && e.coverage == 1));
  REQUIRE(e.scale == Approx(0.5));
  REQUIRE(e.ape.translation.max < 1e-12);
  REQUIRE(e.rpe.translation.max < 1e-12);
  REQUIRE((e.aligned[3].T_world_body.p() - helix(0, 9.9)[3].T_world_body.p()).norm() < 1e-12);
  const Evaluation rigid = evaluate_trajectory(helix(0, 9.9), helix(0, 9.9, 2), {});
  REQUIRE((rigid.ape.translation.rmse > 0.1 && rigid.scale == Approx(0.5)));
}

TEST_CASE("trajectory_evaluation: coverage is the share of the reference's seconds") {
  REQUIRE(evaluate_trajectory(helix(0, 9.9), helix(0, 4.9), {}).coverage == Approx(0.5));
  Trajectory broken = helix(0, 2.9);
  for (const StampedPose& pose : helix(7, 9.9)) broken.push_back(pose);
  REQUIRE(evaluate_trajectory(helix(0, 9.9), broken, {}).coverage == Approx(0.6));
}

TEST_CASE("trajectory_evaluation: too little overlap is an error") {
  Trajectory late = helix(0, 5);
  for (StampedPose& pose : late) pose.t_ns += 3'600'000'000'000;
  REQUIRE(message_of([&] { evaluate_trajectory(helix(0, 5), late, {}); }).find("do both use the same clock?") !=
          std::string::npos);
  REQUIRE(message_of([&] { evaluate_trajectory(helix(0, 0.1), helix(0, 0.1), {}); }).find("cannot align 2 pairs") !=
          std::string::npos);
}

TEST_CASE("trajectory_evaluation: a few pairs of many poses are not evaluated") {
  const Trajectory long_run = helix(0, 454);
  const std::string few = message_of([&] { evaluate_trajectory(long_run, helix(453.8, 900), {}); });
  REQUIRE(few.find("3 of 4463 poses have a partner among the reference's 4541: too few to compare") !=
          std::string::npos);
  const std::string short_run = message_of([&] { evaluate_trajectory(long_run, helix(0, 0.2), {}); });
  REQUIRE(short_run.find("3 of 3 poses have a partner among the reference's 4541: too few") != std::string::npos);
  REQUIRE(evaluate_trajectory(long_run, helix(0, 2), {}).pairs == 21);      // a short part of a long truth
  REQUIRE(evaluate_trajectory(helix(0, 0.4), helix(0, 4), {}).pairs == 5);  // a truth of a part
}

TEST_CASE("trajectory_evaluation: the error of each pair, and the poses without one") {
  Trajectory estimate = helix(0, 9.9);
  for (const StampedPose& pose : helix(20, 20.4)) estimate.push_back(pose);
  estimate[40].T_world_body = SE3<double>(estimate[40].T_world_body.rotation(), Vec<double, 3>(0, 0, 90));
  const Evaluation e = evaluate_trajectory(helix(0, 9.9), estimate, {.alignment = Alignment::none});
  REQUIRE((e.poses == 105 && e.pairs == 100 && e.errors.size() == 100));
  REQUIRE((e.errors[40].t_ns == 4'000'000'000 && e.errors[40].position_m == e.ape.translation.max));
  REQUIRE((e.errors[41].position_m < 1e-12 && e.errors[40].position_m > 80));
}
