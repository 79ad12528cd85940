#include "plumbline/io/calibration_systems.hpp"

#include <string>

#include "catch.hpp"
#include "plumbline/io/calibration.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

const std::string matrix =
    "!!opencv-matrix\n   rows: 4\n   cols: 4\n   dt: f\n   data: [0, 0, 1, 0.1, -1, 0, 0, 0.2, 0, -1, 0, 0.3, 0, 0, 0, "
    "1]\n";
const std::string orb_slam =
    "%YAML:1.0\n\nFile.version: \"1.0\"\nCamera.type: \"PinHole\"\nCamera1.fx: 458.1\nCamera1.fy: 457.2\n"
    "Camera1.cx: 367.2\nCamera1.cy: 248.3\nCamera1.k1: -0.283\nCamera1.k2: 0.0739\nCamera1.p1: 0.000193\n"
    "Camera1.p2: 1.76e-05\nCamera.width: 752\nCamera.height: 480\nCamera.fps: 20\nIMU.T_b_c1: " +
    matrix +
    "IMU.NoiseGyro: 1.7e-04\nIMU.NoiseAcc: 2.0e-03\nIMU.GyroWalk: 1.9e-05\nIMU.AccWalk: 3.0e-03\nIMU.Frequency: 200.0\n"
    "RGBD.DepthMapFactor: 5000.0\nORBextractor.nFeatures: 1000\n";
const std::string vins_camera =
    "%YAML:1.0\n---\nmodel_type: PINHOLE\ncamera_name: camera\nimage_width: 752\nimage_height: 480\n"
    "distortion_parameters:\n   k1: -2.83e-01\n   k2: 7.40e-02\n   p1: 1.9e-04\n   p2: 1.8e-05\n"
    "projection_parameters:\n   fx: 4.587e+02\n   fy: 4.573e+02\n   cx: 3.672e+02\n   cy: 2.484e+02\n";
const std::string vins_noise = "acc_n: 0.08\ngyr_n: 0.004\nacc_w: 0.00004\ngyr_w: 2.0e-6\ntd: 0.005\n";
const std::string basalt = R"({
    "value0": {
        "T_imu_cam": [{"px": 0.1, "py": 0.2, "pz": 0.3, "qx": -0.5, "qy": 0.5, "qz": -0.5, "qw": 0.5}],
        "intrinsics": [{"camera_type": "ds",
            "intrinsics": {"fx": 191, "fy": 192, "cx": 254, "cy": 256, "xi": -0.2, "alpha": 0.6}}],
        "resolution": [[512, 512]],
        "calib_accel_bias": [0.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        "imu_update_rate": 200.0,
        "accel_noise_std": [0.016, 0.016, 0.016], "gyro_noise_std": [0.000282, 0.000282, 0.000282],
        "accel_bias_std": [0.001, 0.001, 0.001], "gyro_bias_std": [0.0001, 0.0001, 0.0001],
        "cam_time_offset_ns": 5000000
    }
})";
const std::string camera_info =
    "header:\n  stamp:\n    sec: 1\n    nanosec: 2\n  frame_id: camera\nheight: 480\nwidth: 640\n"
    "distortion_model: plumb_bob\nd:\n- 0.1\n- -0.2\n- 0.001\n- 0.002\n- 0.0\nk:\n- 500.0\n- 0.0\n- 320.0\n- 0.0\n- "
    "501.0\n"
    "- 240.0\n- 0.0\n- 0.0\n- 1.0\nr: [1, 0, 0, 0, 1, 0, 0, 0, 1]\nbinning_x: 0\n---\n";

const SE3<double> T_forward(SO3<double>::from_matrix((Mat<double, 3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished()),
                            {0.1, 0.2, 0.3});

bool is_forward(const Calibration& calibration) {
  return calibration.T_body_camera && (calibration.T_body_camera->inverse() * T_forward).log().norm() < 1e-6;
}

Calibration read(const std::string& text) {
  const TemporaryDirectory directory;
  return read_calibration(directory.write("calibration.yaml", text));
}

void require_error(const std::string& text, int line, const std::string& what) {
  const TemporaryDirectory directory;
  const auto file = directory.write("calibration.yaml", text);
  const std::string message = message_of([&] { read_calibration(file); });
  CAPTURE(message, line, what);
  REQUIRE(reports(message, file, line, what));
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

}  // namespace

TEST_CASE("calibration_systems: ORB-SLAM3 and its older files") {
  const Calibration now = read(orb_slam);
  REQUIRE((is_forward(now) && now.imu && now.imu->rate_hz == 200 && now.imu->accel_density == 2e-3));
  REQUIRE((now.camera.intrinsics[1] == 457.2 && now.camera.distortion == "radtan" && now.depth_scale == 5000));
  std::string older = replaced(orb_slam, "IMU.T_b_c1", "Tbc");
  for (std::size_t at; (at = older.find("Camera1.")) != std::string::npos;) older.replace(at, 8, "Camera.");
  REQUIRE(is_forward(read(older)));
  require_error(replaced(orb_slam, "Camera.width: 752\n", ""), 0, "key \"Camera.width\" is missing");
  require_error(replaced(orb_slam, "PinHole", "Omni"), 4, "known are PinHole, Rectified and KannalaBrandt8");
}

TEST_CASE("calibration_systems: VINS-Mono in one file, VINS-Fusion in two; noise of one sample") {
  const Calibration mono = read(vins_camera + vins_noise +
                                "extrinsicRotation: {rows: 3, cols: 3, dt: d, data: [0, 0, 1, -1, 0, 0, 0, -1, 0]}\n"
                                "extrinsicTranslation: {rows: 3, cols: 1, dt: d, data: [0.1, 0.2, 0.3]}\n");
  REQUIRE((is_forward(mono) && mono.camera_time_offset_s == 0.005));
  REQUIRE(mono.imu->accel_density == Approx(0.08 / std::sqrt(200.0)));
  REQUIRE((mono.notes.size() == 1 &&
           mono.notes[0].find("acc_n and the others are the noise of one sample") != std::string::npos));
  const TemporaryDirectory directory;
  directory.write("cam0.yaml", vins_camera);
  const auto file =
      directory.write("vins.yaml", "%YAML:1.0\nimu: 1\ncam0_calib: \"cam0.yaml\"\nbody_T_cam0: " + matrix + vins_noise);
  REQUIRE((is_forward(read_calibration(file)) && read_calibration(file).camera.width == 752));
  std::string mei = replaced(vins_camera, "PINHOLE", "MEI") + "mirror_parameters:\n   xi: 1.89\n";
  for (const auto& [from, to] : {std::pair("fx:", "gamma1:"), {"fy:", "gamma2:"}, {"cx:", "u0:"}, {"cy:", "v0:"}})
    mei = replaced(mei, from, to);
  REQUIRE(read(mei).camera.model == "omni");
  REQUIRE(read(mei).camera.intrinsics == std::vector<double>{458.7, 457.3, 367.2, 248.4, 1.89});
  require_error(replaced(vins_camera, "PINHOLE", "SCARAMUZZA"), 3, "a model of VINS that is not read");
}

TEST_CASE("calibration_systems: Basalt") {
  const Calibration calibration = read(basalt);
  REQUIRE((is_forward(calibration) && calibration.camera.model == "double_sphere" && calibration.camera.height == 512));
  REQUIRE((calibration.imu->accel_walk == 0.001 && calibration.camera_time_offset_s == Approx(0.005)));
  REQUIRE((calibration.notes.size() == 1 &&
           calibration.notes[0].find("calib_accel_bias is not applied") != std::string::npos));
  REQUIRE(read(replaced(replaced(basalt, "\"ds\"", "\"eucm\""), "\"xi\": -0.2", "\"beta\": 1.1")).camera.intrinsics ==
          std::vector<double>{191, 192, 254, 256, 0.6, 1.1});
  require_error(replaced(basalt, "\"ds\"", "\"fov\""), 4, "a model of Basalt that is not read");
}

TEST_CASE("calibration_systems: camera_info") {
  const Calibration calibration = read(camera_info);
  REQUIRE((calibration.camera.intrinsics[1] == 501 && calibration.camera.distortion == "radtan"));
  REQUIRE(read(replaced(replaced(camera_info, "plumb_bob", "rational_polynomial"),
                        "- 0.0\nk:", "- 0.0\n- 0.0\n- 0.0\n- 0.0\nk:"))
              .camera.distortion == "radtan");
  const Calibration rational = read(replaced(replaced(camera_info, "plumb_bob", "rational_polynomial"),
                                             "- 0.0\nk:", "- 0.1\n- 0.2\n- 0.3\n- 0.4\nk:"));
  REQUIRE(rational.camera.distortion == "rational");
  REQUIRE(rational.camera.distortion_coefficients == std::vector<double>{0.1, -0.2, 0.001, 0.002, 0.1, 0.2, 0.3, 0.4});
}

TEST_CASE("calibration_systems: OpenVINS names two files; formats that are not read are named") {
  const TemporaryDirectory directory;
  directory.write(
      "imucam.yaml",
      "cam0:\n  T_imu_cam:\n  - [0, 0, 1, 0.1]\n  - [-1, 0, 0, 0.2]\n  - [0, -1, 0, 0.3]\n  - [0, 0, 0, 1]\n"
      "  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  resolution: [640, 480]\n"
      "  distortion_model: none\n");
  directory.write("imu.yaml",
                  "imu0:\n  update_rate: 300\n  gyroscope_noise_density: 1e-4\n  gyroscope_random_walk: 2e-5\n"
                  "  accelerometer_noise_density: 3e-3\n  accelerometer_random_walk: 4e-3\n");
  const auto file = directory.write("estimator_config.yaml",
                                    "%YAML:1.0\nuse_fej: true\nrelative_config_imu: \"imu.yaml\"\n"
                                    "relative_config_imucam: \"imucam.yaml\"\n");
  REQUIRE((is_forward(read_calibration(file)) && read_calibration(file).imu->rate_hz == 300));
  require_error("cameraData:\n- 1\n", 0, "this is a calibration of DepthAI (OAK), which is not read");
  require_error("imu0:\n  update_rate: 200\n", 0, "this is the calibration of an IMU");
}
