#include "plumbline/io/calibration_kitti.hpp"

#include <opencv2/imgcodecs.hpp>
#include <string>

#include "catch.hpp"
#include "plumbline/io/calibration.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

const std::string odometry =
    "P0: 7.18e+02 0.0 6.07e+02 0.0 0.0 7.19e+02 1.85e+02 0.0 0.0 0.0 1.0 0.0\n"
    "P1: 7.18e+02 0.0 6.07e+02 -3.8e+02 0.0 7.19e+02 1.85e+02 0.0 0.0 0.0 1.0 0.0\n";
const std::string raw =
    "calib_time: 09-Jan-2012 13:57:47\ncorner_dist: 9.95e-02\nS_00: 1.392e+03 5.12e+02\n"
    "R_rect_00: 1 0 0 0 1 0 0 0 1\nS_rect_00: 1.242e+03 3.75e+02\n"
    "P_rect_00: 7.215e+02 0 6.095e+02 0 0 7.216e+02 1.728e+02 0 0 0 1 0\n";

}  // namespace

TEST_CASE("calibration_kitti: calib.txt has the size of the first image") {
  const TemporaryDirectory directory;
  const auto file = directory.write("calib.txt", odometry);
  REQUIRE(reports(message_of([&] { read_calibration(file); }), file, 0, "states no image size"));
  directory.write("image_0/000000.png", "");
  cv::imwrite((file.parent_path() / "image_0/000000.png").string(), cv::Mat(376, 1241, CV_8U, cv::Scalar(9)));
  const Calibration c = read_calibration(file);
  REQUIRE((c.camera.width == 1241 && c.camera.height == 376 && c.camera.distortion == "none" && !c.T_body_camera));
  REQUIRE(c.camera.intrinsics == std::vector<double>{718, 719, 607, 185});
  const auto wrong = directory.write("wrong.txt", "a: 1\nP0: 1 2 x\n");
  REQUIRE(
      reports(message_of([&] { read_calibration(wrong); }), wrong, 2, "P0 has \"x\", which is not a finite number"));
}

TEST_CASE("calibration_kitti: the raw files give the transform from the IMU to the rectified camera") {
  const TemporaryDirectory directory;
  const auto file = directory.write("calib_cam_to_cam.txt", raw);
  const Calibration alone = read_calibration(file);
  REQUIRE((alone.camera.width == 1242 && !alone.T_body_camera && alone.notes.size() == 1));
  // velodyne: x forward, y left, z up, as the IMU; the camera z forward, x right, y down
  const auto other = directory.write("calib_velo_to_cam.txt",
                                     "calib_time: 15-Mar-2012 11:37:16\nR: 0 -1 0 0 0 -1 1 0 0\nT: 0 -0.08 -0.27\n");
  directory.write("calib_imu_to_velo.txt", "R: 1 0 0 0 1 0 0 0 1\nT: -0.8 0.3 -0.8\n");
  const Calibration c = read_calibration(file);
  REQUIRE(c.T_body_camera);
  REQUIRE((c.T_body_camera->R().col(2) - Vec<double, 3>(1, 0, 0)).norm() < 1e-12);
  REQUIRE((c.T_body_camera->p() - Vec<double, 3>(0.27 + 0.8, -0.3, -0.08 + 0.8)).norm() < 1e-12);
  REQUIRE(reports(message_of([&] { read_calibration(other); }), other, 0, "this is a transform of KITTI"));
}
