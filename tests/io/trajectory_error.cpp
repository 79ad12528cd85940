#include "plumbline/io/trajectory_error.hpp"

#include <filesystem>
#include <string>
#include <vector>

#include "catch.hpp"
#include "plumbline/io/trajectory_evaluation.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

std::filesystem::path data(const std::string& name) {
  return std::filesystem::path(PLUMBLINE_TEST_DATA) / "trajectories" / name;
}

Evaluation evaluate(const std::string& reference, const std::string& estimate,
                    const EvaluationSettings& settings = {}) {
  return evaluate_trajectory(read_trajectory(data(reference)), read_trajectory(data(estimate)), settings);
}

/// Equal to the digits printed.
auto printed(double value, int digits) { return Approx(value).epsilon(0).margin(0.5000001 * std::pow(10.0, -digits)); }

}  // namespace

TEST_CASE("trajectory_error: statistics") {
  const Statistics s = statistics({4, 1, 2, 3});
  REQUIRE((s.count == 4 && s.min == 1 && s.max == 4 && s.median == 2.5 && s.mean == 2.5));
  REQUIRE(s.rmse == Approx(std::sqrt(30.0 / 4)));
  REQUIRE(s.std == Approx(std::sqrt(5.0 / 4)));
  REQUIRE(statistics({3, 1, 2}).median == 2);
  REQUIRE(statistics({}).count == 0);
}

TEST_CASE("trajectory_error: stretches by frames and by meters") {
  REQUIRE(pairs_by_frames(7, 3) == IndexPairs{{0, 3}, {3, 6}});
  REQUIRE(pairs_by_frames(3, 3).empty());
  std::vector<PosePair> pairs;
  pairs.reserve(8);
  for (int i = 0; i < 8; ++i) pairs.push_back({i, {}, SE3<double>({}, {0.4 * i, 0, 0})});
  REQUIRE(pairs_by_meters(pairs, 1) == IndexPairs{{3, 6}});
}

TEST_CASE("trajectory_error: one degree of drift in each step") {
  std::vector<PosePair> pairs;
  pairs.reserve(8);
  for (int i = 0; i < 5; ++i)
    pairs.push_back({i, SE3<double>({}, {1.0 * i, 0, 0}),
                     SE3<double>(SO3<double>::exp({0, 0, 0.017453292519943295 * i}), {1.1 * i, 0, 0})});
  const PoseError error = relative_error(pairs, pairs_by_frames(5, 1));
  REQUIRE(error.rotation_deg.min == Approx(1));
  REQUIRE(error.rotation_deg.max == Approx(1));
  REQUIRE(error.translation.min == Approx(0.1));
  REQUIRE(absolute_error(pairs).translation.max == Approx(0.4));
  REQUIRE(absolute_error(pairs).rotation_deg.max == Approx(4));
}

TEST_CASE("trajectory_error: the known figures of KITTI 00", "[data]") {
  if (skip_without(data("KITTI_00_gt.txt"))) return;
  const EvaluationSettings ten_meters{.rpe_delta = 10, .rpe_unit = DeltaUnit::meters};
  const Statistics ape = evaluate("KITTI_00_gt.txt", "KITTI_00_ORB.txt", ten_meters).ape.translation;
  REQUIRE(ape.rmse == printed(1.30344971, 8));
  REQUIRE(ape.mean == printed(1.15699713, 8));
  REQUIRE(ape.median == printed(1.06562477, 8));
  REQUIRE(ape.std == printed(0.60028227, 8));
  REQUIRE(ape.min == printed(0.06931322, 8));
  REQUIRE(ape.max == printed(3.58794912, 8));
  // The file's rotations have seven digits; they are made orthonormal here, which moves the eighth of these.
  const Statistics rpe = evaluate("KITTI_00_gt.txt", "KITTI_00_ORB.txt", ten_meters).rpe.translation;
  REQUIRE(rpe.rmse == printed(0.2262613, 6));
  REQUIRE(rpe.mean == printed(0.1690174, 6));
  REQUIRE(rpe.max == printed(1.2722091, 6));
}

TEST_CASE("trajectory_error: the known figures of fr1/xyz", "[data]") {
  if (skip_without(data("freiburg1_xyz-groundtruth.txt"))) return;
  const Evaluation e = evaluate("freiburg1_xyz-groundtruth.txt", "freiburg1_xyz-rgbdslam.txt");
  REQUIRE(e.pairs == 786);
  REQUIRE(e.ape.translation.rmse == printed(0.013473, 6));
  REQUIRE(e.ape.translation.mean == printed(0.012029, 6));
  REQUIRE(e.ape.translation.median == printed(0.011176, 6));
  REQUIRE(e.ape.translation.std == printed(0.006068, 6));
  REQUIRE(e.ape.translation.max == printed(0.034727, 6));
  REQUIRE(e.rpe.translation.count == 753);
  REQUIRE(e.rpe.translation.rmse == printed(0.021217, 6));
  REQUIRE(e.rpe.translation.mean == printed(0.019524, 6));
  REQUIRE(e.rpe.rotation_deg.rmse == printed(0.934480, 6));
}

TEST_CASE("trajectory_error: the known figures of fr2/desk", "[data]") {
  if (skip_without(data("fr2_desk_groundtruth.txt"))) return;
  const Evaluation e = evaluate("fr2_desk_groundtruth.txt", "fr2_desk_ORB.txt");
  REQUIRE(e.pairs == 2223);
  REQUIRE(e.ape.translation.rmse == printed(0.008144, 6));
  REQUIRE(e.ape.translation.mean == printed(0.007514, 6));
  REQUIRE(e.ape.translation.max == printed(0.024329, 6));
  REQUIRE(e.rpe.translation.count == 1998);
  REQUIRE(e.rpe.translation.rmse == printed(0.007161, 6));
  REQUIRE(e.rpe.rotation_deg.rmse == printed(0.455005, 6));

  const Evaluation mono = evaluate("fr2_desk_groundtruth.txt", "fr2_desk_ORB_kf_mono.txt");
  REQUIRE((mono.pairs == 122 && mono.scale > 2));
  REQUIRE(mono.ape.translation.rmse == printed(0.948813, 6));
  REQUIRE(evaluate("fr2_desk_groundtruth.txt", "fr2_desk_ORB_kf_mono.txt", {.alignment = Alignment::sim3})
              .ape.translation.rmse < 0.01);
}
