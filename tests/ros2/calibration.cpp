#include "plumbline_ros2/calibration.hpp"

#include <fstream>
#include <string>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::ros2;

namespace {

const Configuration with_imu{"mono-imu/points/window", {.depth = false, .imu = true}, nullptr};
const Configuration with_depth{"rgbd/points/window", {.depth = true, .imu = false}, nullptr};
const plumbline::io::bag::CameraInfoMessage info{640, 480, "plumb_bob", {}, {500, 0, 320, 0, 500, 240, 0, 0, 1}};

}  // namespace

TEST_CASE("camera_info is enough without an IMU, and depth is in millimeters unless stated") {
  Parameters p;
  REQUIRE(needs_camera_info(p, with_depth));
  REQUIRE(calibration_of(p, with_depth, info).camera.width == 640);
  REQUIRE(calibration_of(p, with_depth, info).depth_scale == 1000);
  p.depth_scale = 5000;
  REQUIRE(calibration_of(p, with_depth, info).depth_scale == 5000);
  REQUIRE(message_of([] { needs_camera_info({}, with_imu); }).find("needs a file") != std::string::npos);
  p.imu_calibration = "imu.yaml";
  REQUIRE(message_of([&] { needs_camera_info(p, with_depth); }).find("goes with calibration") != std::string::npos);
}

TEST_CASE("a file is read, and must have what the configuration needs") {
  const TemporaryDirectory folder;
  Parameters p;
  p.calibration = (folder.path() / "calibration.yaml").string();
  p.mask = "mask.png";
  std::ofstream(p.calibration) << "camera: {model: pinhole, intrinsics: [300, 300, 160, 120], resolution: [320, 240]}\n"
                                  "depth: {scale: 5000}\n";
  REQUIRE(!needs_camera_info(p, with_depth));
  const plumbline::io::Calibration calibration = calibration_of(p, with_depth, {});
  REQUIRE(calibration.camera.height == 240);
  REQUIRE(calibration.depth_scale == 5000);
  REQUIRE(calibration.mask->string() == "mask.png");
  REQUIRE(message_of([&] { calibration_of(p, with_imu, {}); }).find("needs the noise of the IMU") != std::string::npos);
}
