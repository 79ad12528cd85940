#include "plumbline/io/calibration_okvis.hpp"

#include <string>

#include "catch.hpp"
#include "plumbline/io/calibration.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

const std::string okvis = R"(%YAML:1.0
cameras:
     - {T_SC:
        [0, 0, 1, 0.1,
         -1, 0, 0, 0.2,
         0, -1, 0, 0.3,
         0, 0, 0, 1],
        image_dimension: [752, 480],
        distortion_coefficients: [-0.28, 0.07, 1.9e-4, 1.7e-5],
        distortion_type: radialtangential,
        focal_length: [458.6, 457.2],
        principal_point: [367.2, 248.3],
        camera_type: gray,
        slam_use: okvis}
camera_parameters:
    image_delay: 0.005
imu_parameters:
    use: true
    a_max: 176.0
    g_max: 7.8
    sigma_g_c: 2.0e-4
    sigma_a_c: 2.0e-3
    sigma_gw_c: 2.0e-5
    sigma_aw_c: 3.0e-3
    g: 9.81007
)";

Calibration read(const std::string& text) {
  const TemporaryDirectory directory;
  return read_calibration(directory.write("okvis.yaml", text));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("calibration_okvis: camera, transform, delay and noise") {
  const Calibration c = read(okvis);
  REQUIRE(c.camera.intrinsics == std::vector<double>{458.6, 457.2, 367.2, 248.3});
  REQUIRE((c.camera.distortion == "radtan" && c.camera.width == 752));
  REQUIRE((c.T_body_camera->p() - Vec<double, 3>(0.1, 0.2, 0.3)).norm() < 1e-12);
  REQUIRE((c.T_body_camera->R().col(2) - Vec<double, 3>(1, 0, 0)).norm() < 1e-12);  // the camera looks along x
  REQUIRE(c.camera_time_offset_s == -0.005);                                        // the stamps are late by the delay
  REQUIRE((c.imu->gyro_density == 2e-4 && c.imu->accel_walk == 3e-3 && c.imu->rate_hz == 200));
  REQUIRE((c.imu_limits.gyro_full_scale == 7.8 && c.imu_limits.accel_full_scale == 176));
  REQUIRE(c.notes.empty());
}

TEST_CASE("calibration_okvis: the rational model, and errors with their line") {
  const Calibration c =
      read(replaced(replaced(okvis, "radialtangential", "radialtangential8"), "[-0.28, 0.07, 1.9e-4, 1.7e-5]",
                    "[18, 12.6, 1e-4, -7e-5, 0.7, 18.3, 18.2, 3.1]"));
  REQUIRE((c.camera.distortion == "rational" && c.camera.distortion_coefficients.size() == 8));
  const TemporaryDirectory directory;
  const auto error = [&](const std::string& text, int line, const std::string& what) {
    const auto file = directory.write("okvis.yaml", text);
    const std::string message = message_of([&] { read_calibration(file); });
    CAPTURE(message);
    REQUIRE(reports(message, file, line, what));
  };
  error(replaced(okvis, "[458.6, 457.2]", "[458.6]"), 11, "must have 2 values, has 1");
  error(replaced(okvis, "sigma_a_c: 2.0e-3", "sigma_a_c: 200"), 22, "sigma_a_c must be from");
  error(replaced(okvis, "T_SC", "T_B_C"), 0, "this is a calibration of Maplab, which is not read");
}
