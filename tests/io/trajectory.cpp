#include "plumbline/io/trajectory.hpp"

#include <string>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

void require_error(const std::string& text, int line, const std::string& what) {
  const TemporaryDirectory directory;
  const auto file = directory.write("trajectory.txt", text);
  const std::string message = message_of([&] { read_trajectory(file); });
  CAPTURE(message, line, what);
  REQUIRE(reports(message, file, line, what));
}

const double half = 0.70710678118654757;

}  // namespace

TEST_CASE("trajectory: TUM rows, x y z w") {
  const TemporaryDirectory directory;
  const auto file = directory.write("a.txt", "# t p q\n1403636624.363555584 1 2 3 0 0 0.70710678118 0.70710678118\n");
  const Trajectory t = read_trajectory(file);
  REQUIRE((t.size() == 1 && t[0].t_ns == 1403636624363555584));
  REQUIRE(t[0].T_world_body.p() == Vec<double, 3>(1, 2, 3));
  REQUIRE((t[0].T_world_body.rotation() * Vec<double, 3>(1, 0, 0) - Vec<double, 3>(0, 1, 0)).norm() < 1e-9);
}

TEST_CASE("trajectory: EuRoC rows, w x y z, short and long") {
  const TemporaryDirectory directory;
  for (const char* tail : {"", ",0.1,0.2,0.3,0,0,0,0,0,0"}) {
    const auto file = directory.write(
        "a.csv", std::string("#timestamp [ns],p\n1403636623863560000,1,2,3,0.70710678118,0,0,0.70710678118") + tail);
    const Trajectory t = read_trajectory(file);
    REQUIRE((t.size() == 1 && t[0].t_ns == 1403636623863560000));
    REQUIRE((t[0].T_world_body.rotation() * Vec<double, 3>(1, 0, 0) - Vec<double, 3>(0, 1, 0)).norm() < 1e-9);
  }
}

TEST_CASE("trajectory: KITTI rows, with and without times") {
  const TemporaryDirectory directory;
  const auto file = directory.write("poses.txt", "1 0 0 4 0 1 0 5 0 0 1 6\n0 -1 0 4 1 0 0 5 0 0 1 7\n");
  Trajectory t = read_trajectory(file);
  REQUIRE((t.size() == 2 && t[0].t_ns == 0 && t[1].t_ns == 1000000000));
  REQUIRE(t[1].T_world_body.p() == Vec<double, 3>(4, 5, 7));
  REQUIRE((t[1].T_world_body.rotation() * Vec<double, 3>(1, 0, 0) - Vec<double, 3>(0, 1, 0)).norm() < 1e-12);
  directory.write("times.txt", "0.000000e+00\n1.037359e-01\n");
  t = read_trajectory(file);
  REQUIRE(t[1].t_ns == 103735900);
}

TEST_CASE("trajectory: of rows with the same time the last one counts") {
  const TemporaryDirectory directory;
  const auto file = directory.write("a.txt", "1 0 0 0 0 0 0 1\n1 5 0 0 0 0 0 1\n2 0 0 0 0 0 0 1\n");
  const Trajectory t = read_trajectory(file);
  REQUIRE((t.size() == 2 && t[0].T_world_body.p().x() == 5));
}

TEST_CASE("trajectory: rows that cannot be used") {
  require_error("", 0, "no poses");
  require_error("# only a comment\n", 0, "no poses");
  require_error("1 0 0 0 0 0 1\n", 1, "neither TUM (8 columns)");
  require_error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n", 2, "expected 8 columns, found 7");
  require_error("1 0 0 0 0 0 0 1\n2 0 nan 0 0 0 0 1\n", 2, "column 3: \"nan\"");
  require_error("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 0 0\n", 2, "unit length");
  require_error("2 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n", 2, "before that of the row above");
  require_error("x 0 0 0 0 0 0 1\n", 1, "\"x\" is not a time stamp");
  require_error("1.5,0,0,0,1,0,0,0\n", 1, "\"1.5\" is not a time stamp");
  require_error("1 0 0 4 0 1 0 5 0 0 2 6\n", 1, "not a rotation");
  require_error("1 0 0 4 0 1 0 5 0 0 -1 6\n", 1, "not a rotation");
  REQUIRE(reports(message_of([] { read_trajectory("/nowhere.txt"); }), "/nowhere.txt", 0, "no such file"));
}

TEST_CASE("trajectory: what is written is read back, its times exactly") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "out.tum";
  const Trajectory t{{1403636624363555584, {SO3<double>::exp({0.1, -2, 0.3}), {1234.567890123, -2, 3e-7}}},
                     {1403636624413555001, {SO3<double>(Eigen::Quaterniond(half, 0, 0, half)), {0, 0, 0}}}};
  TrajectoryWriter writer(file);
  for (const StampedPose& pose : t) writer.add(pose);
  REQUIRE(!std::filesystem::exists(file));
  writer.commit();
  const Trajectory read = read_trajectory(file);
  REQUIRE(read.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    REQUIRE(read[i].t_ns == t[i].t_ns);
    REQUIRE((read[i].T_world_body.inverse() * t[i].T_world_body).log().norm() < 2e-9);
  }
  REQUIRE(!std::filesystem::exists(file.string() + ".part"));
}

TEST_CASE("trajectory: a writer that never commits leaves nothing") {
  const TemporaryDirectory directory;
  { TrajectoryWriter(directory.path() / "out.tum").add({1, {}}); }
  REQUIRE(std::filesystem::is_empty(directory.path()));
  REQUIRE(
      reports(message_of([] { TrajectoryWriter("/nowhere/out.tum"); }), "/nowhere/out.tum", 0, "cannot be written"));
}

TEST_CASE("trajectory: the camera moves with the body") {
  const SE3<double> T_body_camera({}, {1, 0, 0});
  const Trajectory body{{0, {SO3<double>(Eigen::Quaterniond(half, 0, 0, half)), {0, 0, 5}}}};
  REQUIRE((moved_to(body, T_body_camera)[0].T_world_body.p() - Vec<double, 3>(0, 1, 5)).norm() < 1e-12);
}
