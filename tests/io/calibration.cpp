#include "plumbline/io/calibration.hpp"

#include <algorithm>
#include <string>

#include "catch.hpp"
#include "plumbline/io/make_camera.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

const std::string plain = R"(camera:
  model: pinhole
  intrinsics: [500.0, 501, 320, 240]   # fx fy cx cy
  distortion: radtan
  distortion_coefficients: [0.1, -0.2, 0.001, 0.002, 0.3]
  resolution: [640, 480]
  rate_hz: 30
depth:
  scale: 5000
T_body_camera:
  [0, 0, 1, 0.1,
   -1, 0, 0, 0.2,
   0, -1, 0, 0.3,
   0, 0, 0, 1]
imu:
  rate_hz: 200
  gyroscope_noise_density: 1e-4
  gyroscope_random_walk: 2e-5
  accelerometer_noise_density: 3e-3
  accelerometer_random_walk: 4e-3
)";

const std::string euroc = R"(%YAML:1.0
sensor_type: camera
comment: left
T_BS:
  cols: 4
  rows: 4
  data: [0, 0, 1, 0.1,
         -1, 0, 0, 0.2,
         0, -1, 0, 0.3,
         0, 0, 0, 1]
rate_hz: 20
resolution: [752, 480]
camera_model: pinhole
intrinsics: [458.654, 457.296, 367.215, 248.375]
distortion_model: radial-tangential
distortion_coefficients: [-0.28, 0.07, 0.0002, 1.8e-05]
)";

const std::string kalibr = R"(cam0:
  T_cam_imu:
  - [0.0, -1.0, 0.0, 0.2]
  - [0.0, 0.0, -1.0, 0.3]
  - [1.0, 0.0, 0.0, -0.1]
  - [0.0, 0.0, 0.0, 1.0]
  cam_overlaps: []
  camera_model: pinhole
  distortion_coeffs: [0.01, 0.02, 0.03, 0.04]
  distortion_model: equidistant
  intrinsics: [190.9, 190.8, 254.9, 256.9]
  resolution: [512, 512]
  rostopic: /cam0/image_raw
  timeshift_cam_imu: 0.012
)";

const std::string kalibr_imu = R"(accelerometer_noise_density: 0.0028
accelerometer_random_walk: 0.00086
gyroscope_noise_density: 0.00016
gyroscope_random_walk: 2.2e-05
rostopic: /imu0
update_rate: 200.0
)";

const std::string opencv_yaml = R"(%YAML:1.0
---
calibration_time: "Tue 01 Jan 2030"
image_width: 640
image_height: 480
flags: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 500., 0., 320., 0., 501., 240., 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 1.e-01, -2.e-01, 0., 0., 3.e-01 ]
avg_reprojection_error: 0.2
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  REQUIRE(at != std::string::npos);
  return text.replace(at, from.size(), to);
}

/// Parsing `text` fails, with `what` in the message, for the given line.
void require_error(const std::string& text, int line, const std::string& what) {
  const TemporaryDirectory directory;
  const auto file = directory.write("calibration.yaml", text);
  const std::string message = message_of([&] { read_calibration(file); });
  CAPTURE(message, line, what);
  REQUIRE(reports(message, file, line, what));
}

Calibration read(const std::string& text) {
  const TemporaryDirectory directory;
  return read_calibration(directory.write("calibration.yaml", text));
}

const SE3<double> T_forward(SO3<double>::from_matrix((Mat<double, 3, 3>() << 0, 0, 1, -1, 0, 0, 0, -1, 0).finished()),
                            {0.1, 0.2, 0.3});

}  // namespace

TEST_CASE("calibration: the plain format") {
  const Calibration c = read(plain);
  REQUIRE((c.camera.model == "pinhole" && c.camera.distortion == "radtan"));
  REQUIRE(c.camera.intrinsics == std::vector<double>{500, 501, 320, 240});
  REQUIRE(c.camera.distortion_coefficients == std::vector<double>{0.1, -0.2, 0.001, 0.002, 0.3});
  REQUIRE((c.camera.width == 640 && c.camera.height == 480 && c.camera.rate_hz == 30));
  REQUIRE(c.depth_scale == 5000);
  REQUIRE((c.T_body_camera->inverse() * T_forward).log().norm() < 1e-12);
  REQUIRE((c.imu->gyro_density == 1e-4 && c.imu->gyro_walk == 2e-5));
  REQUIRE((c.imu->accel_density == 3e-3 && c.imu->accel_walk == 4e-3 && c.imu->rate_hz == 200));
}

TEST_CASE("calibration: stated full scales of the IMU, and the usual ones") {
  const ImuBufferOptions usual;
  REQUIRE((read(plain).imu_limits.gyro_full_scale == usual.gyro_full_scale &&
           read(plain).imu_limits.accel_full_scale == usual.accel_full_scale));
  const std::string stated = "gyroscope_full_scale: 8.73\naccelerometer_full_scale: 39.2\n";
  const auto small = [](const Calibration& c) {
    return c.imu_limits.gyro_full_scale == 8.73 && c.imu_limits.accel_full_scale == 39.2;
  };
  REQUIRE(small(read(plain + "  gyroscope_full_scale: 8.73\n  accelerometer_full_scale: 39.2\n")));
  const TemporaryDirectory directory;
  const auto camera = directory.write("camchain.yaml", kalibr);
  REQUIRE(small(read_calibration(camera, directory.write("imu.yaml", kalibr_imu + stated))));
  require_error(plain + "  gyroscope_full_scale: 0\n", 21,
                "imu.gyroscope_full_scale must be from 0.1 to 1000 rad/s, is 0");
}

TEST_CASE("calibration: a stated readout time, and none") {
  REQUIRE(!read(plain).camera.readout_s);
  REQUIRE(*read(replaced(plain, "rate_hz: 30", "readout_s: 0.026")).camera.readout_s == 0.026);
  require_error(replaced(plain, "rate_hz: 30", "readout_s: 26"), 7, "camera.readout_s must be from 0 to 0.2 seconds");
  REQUIRE(*read(replaced(euroc, "rate_hz: 20", "readout_s: 0.026")).camera.readout_s == 0.026);
  REQUIRE(*read(replaced(opencv_yaml, "flags: 0", "readout_s: 0.026")).camera.readout_s == 0.026);
  const auto stated = [](const std::string& line) { return replaced(kalibr, "timeshift_cam_imu: 0.012", line); };
  REQUIRE(*read(stated("readout_s: 0.026")).camera.readout_s == 0.026);
  REQUIRE(*read(stated("line_delay: 5.0e-05")).camera.readout_s == Approx(511 * 5e-5));
  require_error(stated("line_delay: 1.0e-3"), 14, "cam0.line_delay must be from 0 to 0.2 seconds for all rows");
}

TEST_CASE("calibration: the mask of the plain format is found from its file's folder") {
  const TemporaryDirectory directory;
  REQUIRE(!read(plain).mask);
  const auto of = [&](const std::string& mask) {
    return *read_calibration(directory.write("calibration.yaml", replaced(plain, "rate_hz: 30", "mask: " + mask))).mask;
  };
  REQUIRE(of("masks/bonnet.png") == directory.path() / "masks/bonnet.png");
  REQUIRE(of("/elsewhere/bonnet.png") == "/elsewhere/bonnet.png");
}

TEST_CASE("calibration: EuRoC, T_BS is the camera in the body") {
  const Calibration c = read(euroc);
  REQUIRE((c.camera.distortion == "radtan" && c.camera.distortion_coefficients.size() == 4));
  REQUIRE((c.camera.width == 752 && c.camera.height == 480 && c.camera.rate_hz == 20));
  REQUIRE((c.T_body_camera->inverse() * T_forward).log().norm() < 1e-12);
  REQUIRE((!c.imu && c.depth_scale == 0));
}

TEST_CASE("calibration: Kalibr, T_cam_imu is the inverse") {
  const TemporaryDirectory directory;
  const auto camera = directory.write("camchain.yaml", kalibr);
  const Calibration c = read_calibration(camera, directory.write("imu.yaml", kalibr_imu));
  REQUIRE((c.camera.model == "pinhole" && c.camera.distortion == "equidistant"));
  REQUIRE((c.T_body_camera->inverse() * T_forward).log().norm() < 1e-12);
  REQUIRE(c.camera_time_offset_s == 0.012);
  REQUIRE((c.imu->accel_density == 0.0028 && c.imu->gyro_walk == 2.2e-5 && c.imu->rate_hz == 200));
  REQUIRE(!read_calibration(camera).imu);
}

TEST_CASE("calibration: Kalibr's double sphere has xi and alpha first") {
  std::string text = replaced(kalibr, "camera_model: pinhole", "camera_model: ds");
  text = replaced(text, "distortion_model: equidistant", "distortion_model: none");
  text = replaced(text, "[190.9, 190.8, 254.9, 256.9]", "[-0.2, 0.59, 190.9, 190.8, 254.9, 256.9]");
  const Calibration c = read(text);
  REQUIRE(c.camera.model == "double_sphere");
  REQUIRE(c.camera.intrinsics == std::vector<double>{190.9, 190.8, 254.9, 256.9, -0.2, 0.59});
}

TEST_CASE("calibration: Kalibr's omni, eucm and fov") {
  const std::string omni = replaced(replaced(replaced(kalibr, "camera_model: pinhole", "camera_model: omni"),
                                             "distortion_model: equidistant", "distortion_model: radtan"),
                                    "[190.9, 190.8, 254.9, 256.9]", "[1.3, 390.9, 390.8, 254.9, 256.9]");
  const Calibration o = read(omni);
  REQUIRE((o.camera.model == "omni" && o.camera.distortion == "radtan"));
  REQUIRE(o.camera.intrinsics == std::vector<double>{390.9, 390.8, 254.9, 256.9, 1.3});
  REQUIRE(make_camera<double>(o.camera).model().index() == 6);
  require_error(replaced(omni, "[1.3,", "[-1.3,"), 11, "must have xi in [0, 10], has -1.3");
  require_error(replaced(omni, "radtan", "equidistant"), 9, "omni takes no other distortion");

  std::string eucm = replaced(replaced(kalibr, "camera_model: pinhole", "camera_model: eucm"),
                              "distortion_model: equidistant", "distortion_model: none");
  eucm = replaced(eucm, "[190.9, 190.8, 254.9, 256.9]", "[0.6, 1.1, 190.9, 190.8, 254.9, 256.9]");
  const Calibration e = read(eucm);
  REQUIRE(e.camera.intrinsics == std::vector<double>{190.9, 190.8, 254.9, 256.9, 0.6, 1.1});
  REQUIRE(make_camera<double>(e.camera).model().index() == 7);

  std::string fov = replaced(kalibr, "distortion_model: equidistant", "distortion_model: fov");
  const std::size_t at = fov.find("distortion_coeffs: "), end = fov.find('\n', at);
  fov.replace(at, end - at, "distortion_coeffs: [0.92]");
  const Calibration f = read(fov);
  REQUIRE((f.camera.distortion == "fov" && f.camera.distortion_coefficients == std::vector<double>{0.92}));
  REQUIRE(make_camera<double>(f.camera).model().index() == 5);
  require_error(replaced(fov, "[0.92]", "[0.92, 0.1]"), 9, "must have 1 value (w, 0 to 3.14 rad), has 2");
}

TEST_CASE("calibration: OpenCV's 8 coefficients are the rational model") {
  std::string text = opencv_yaml;
  const std::size_t at = text.find("distortion_coefficients"), end = text.find(']', at);
  text.replace(at, end + 1 - at, "distortion_coefficients: [0.5, -2.7, 1e-4, 2e-4, 1.5, 0.4, -2.5, 1.4, 0, 0, 0, 0]");
  const Calibration c = read(text);
  REQUIRE((c.camera.distortion == "rational" && c.camera.distortion_coefficients.size() == 8));
  REQUIRE(make_camera<double>(c.camera).model().index() == 4);
}

TEST_CASE("calibration: OpenCV matrices") {
  const Calibration c = read(opencv_yaml);
  REQUIRE(c.camera.intrinsics == std::vector<double>{500, 501, 320, 240});
  REQUIRE(c.camera.distortion == "radtan");
  REQUIRE(c.camera.distortion_coefficients == std::vector<double>{0.1, -0.2, 0, 0, 0.3});
  REQUIRE((c.camera.width == 640 && c.camera.height == 480 && !c.T_body_camera));
}

TEST_CASE("calibration: make_camera projects as the model") {
  const AnyCamera<double> camera = make_camera<double>(read(plain).camera);
  const Projection<double> center = camera.project({0, 0, 2});
  REQUIRE((center.valid && center.uv.isApprox(Vec<double, 2>(320, 240))));
  const double x = 0.1, r2 = x * x, d = 1 + 0.1 * r2 - 0.2 * r2 * r2 + 0.3 * r2 * r2 * r2;
  const Vec<double, 2> expected(320 + 500 * (x * d + 0.002 * 3 * r2), 240 + 501 * 0.001 * r2);
  REQUIRE((camera.project({2 * x, 0, 2}).uv - expected).norm() < 1e-9);
  REQUIRE(make_camera<float>(read(kalibr).camera).model().index() == 2);
  REQUIRE(make_camera<float>(read(replaced(opencv_yaml, "1.e-01, -2.e-01, 0., 0., 3.e-01", "0, 0, 0, 0, 0")).camera)
              .model()
              .index() == 1);
  REQUIRE_THROWS(make_camera<float>(CameraCalibration{}));
}

TEST_CASE("calibration: a transform that is none") {
  require_error(replaced(plain, "-1, 0, 0, 0.2", "-0.9, 0, 0, 0.2"), 11, "not orthonormal");
  require_error(replaced(plain, "-1, 0, 0, 0.2", "1, 0, 0, 0.2"), 11, "reflection");
  require_error(replaced(plain, "0, 0, 0, 1]", "0, 0, 1, 1]"), 11, "last row 0 0 0 1");
  require_error(replaced(plain, "0, 0, 0, 1]", "0, 0, 0]"), 11, "must have 16 values (4x4, row by row), has 15");
  require_error(replaced(plain, "0, 0, 1, 0.1", "0, 0, .nan, 0.1"), 11, "not a finite number");
  require_error(replaced(plain, "-1, 0, 0, 0.2", "-1, 0, 0, abc"), 12, "\"abc\" is not a finite number");
}

TEST_CASE("calibration: numbers that cannot be") {
  require_error(replaced(plain, "[500.0,", "[0,"), 3, "focal lengths that are not positive");
  require_error(replaced(plain, "[500.0, 501", "[500.0, -501"), 3, "focal lengths that are not positive: 500, -501");
  require_error(replaced(plain, "[500.0,", "[nan,"), 3, "\"nan\" is not a finite number");
  require_error(replaced(plain, ", 240]", "]"), 3, "must have 4 values, has 3");
  require_error(replaced(plain, "[640, 480]", "[640, -480]"), 6, "two positive whole numbers, has -480");
  require_error(replaced(plain, "[640, 480]", "[640]"), 6, "[width, height]");
  require_error(replaced(plain, "[640, 480]", "[320, 240]"), 6, "does not contain the principal point (320, 240)");
  require_error(replaced(replaced(plain, "320, 240]", "320, 500]"), "[640, 480]", "[640, 480]"), 6, "principal point");
  require_error(replaced(euroc, "[752, 480]", "[300, 752]"), 12, "principal point");
  require_error(replaced(plain, "rate_hz: 30", "rate_hz: 0"), 7, "camera.rate_hz must be from 0.01 to 10000 Hz, is 0");
  require_error(replaced(plain, "scale: 5000", "scale: -1"), 9, "depth.scale must be from 1 to 1e+06 units per meter");
  require_error(replaced(plain, "density: 1e-4", "density: 0"), 17, "imu.gyroscope_noise_density must be from");
  require_error(replaced(plain, "walk: 4e-3", "walk: .inf"), 20, "not a finite number");
  require_error(replaced(plain, "0.002, 0.3]", "0.002, 0.3, 0.1]"), 5, "4 or 5 values");
}

TEST_CASE("calibration: numbers beyond everything there is") {
  require_error(replaced(plain, "[500.0,", "[1e30,"), 3, "a focal length of 1e+30 px; must be from 1 to 100000 px");
  require_error(replaced(plain, "-0.2, 0.001", "-1e9, 0.001"), 5, "a value of -1e+09; must be from -1e+06 to 1e+06");
  require_error(replaced(plain, "rate_hz: 30", "rate_hz: 1e9"), 7, "camera.rate_hz must be from 0.01 to 10000 Hz");
  require_error(replaced(plain, "rate_hz: 30", "time_offset_s: 1e10"), 7,
                "camera.time_offset_s must be from -3600 to 3600 s, is 1e10");
  require_error(replaced(plain, "scale: 5000", "scale: 0.001"), 9, "depth.scale must be from 1 to 1e+06");
  require_error(replaced(plain, "0, 0, 1, 0.1", "0, 0, 1, 1e300"), 11, "a translation of 1e+300 m");
  require_error(replaced(plain, "density: 3e-3", "density: 1e300"), 19,
                "imu.accelerometer_noise_density must be from 1e-07 to 10 m/s^2/sqrt(Hz), is 1e300");
  require_error(replaced(plain, "walk: 2e-5", "walk: 1e-300"), 18, "imu.gyroscope_random_walk must be from");
  require_error(replaced(plain, "rate_hz: 200", "rate_hz: 1e9"), 16, "imu.rate_hz must be from 1 to 100000 Hz");
  require_error(replaced(kalibr, "timeshift_cam_imu: 0.012", "timeshift_cam_imu: 1e5"), 14, "from -3600 to 3600 s");
}

TEST_CASE("calibration: aliases that contain themselves, or make much of little") {
  require_error(replaced(plain, "[500.0, 501, 320, 240]", "&a [500, 501, 320, *a]"), 3, "camera.intrinsics");
  require_error(replaced(plain, "[500.0, 501, 320, 240]", "&a [[500, 501], *a]"), 3, "nested deeper");
  std::string levels = "comment:\n  - &l0 [1, 1, 1, 1, 1, 1, 1, 1, 1]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string alias = "*l" + std::to_string(i - 1);
    levels += "  - &l" + std::to_string(i) + " [" + alias;
    for (int k = 0; k < 8; ++k) levels += ", " + alias;
    levels += "]\n";
  }
  const auto with = [&](const char* alias) {
    return levels + replaced(euroc.substr(euroc.find("T_BS")), "[458.654, 457.296, 367.215, 248.375]", alias);
  };
  require_error(with("*l9"), 9, "intrinsics is nested deeper than the rows of a matrix");
  require_error(with("[*l0, *l0, *l0, *l0, *l0, *l0, *l0, *l0, *l0, *l0, *l0, *l0]"), 2, "has more than 100 numbers");
}

TEST_CASE("calibration: control characters do not reach the terminal") {
  require_error(replaced(plain, "model: pinhole", "model: \"pin\\e[31m\""), 2, "is \"pin\\x1b[31m\"");
}

TEST_CASE("calibration: a swapped resolution is named") {
  require_error(replaced(replaced(plain, "320, 240]", "400, 240]"), "[640, 480]", "[380, 640]"), 6, "swapped");
  require_error(replaced(plain, "[640, 480]", "[300, 640]"), 6, "are width and height swapped?");
}

TEST_CASE("calibration: keys unknown, repeated, missing") {
  require_error(replaced(plain, "rate_hz: 30", "rate_hs: 30"), 7, "unknown key \"rate_hs\", did you mean \"rate_hz\"?");
  require_error(replaced(plain, "distortion_coefficients", "distortion_coeffs"), 5,
                "did you mean \"distortion_coefficients\"?");
  require_error(replaced(plain, "T_body_camera", "T_camera_body"), 10, "known are camera, depth, T_body_camera, imu");
  require_error(replaced(plain, "T_body_camera", "T_body_cam"), 10, "did you mean \"T_body_camera\"?");
  require_error(replaced(euroc, "camera_model", "camera_modell"), 13, "did you mean \"camera_model\"?");
  require_error(replaced(plain, "  rate_hz: 30", "  model: pinhole"), 7, "key \"model\" appears twice");
  require_error(replaced(plain, "  model: pinhole\n", ""), 2, "key \"camera.model\" is missing");
  require_error(replaced(plain, "  gyroscope_random_walk: 2e-5\n", ""), 16,
                "key \"imu.gyroscope_random_walk\" is missing");
  require_error(plain.substr(0, plain.find("T_body_camera")) + plain.substr(plain.find("imu:")), 0,
                "key \"T_body_camera\" is missing");
  require_error(replaced(plain, "model: pinhole", "model: pinhle"), 2,
                "known are pinhole, double_sphere, omni and eucm");
  require_error(replaced(plain, "distortion: radtan", "distortion: cubic"), 4,
                "known are none, radtan, rational, equidistant and fov");
}

TEST_CASE("calibration: files that are no calibration") {
  require_error("", 0, "not a YAML mapping");
  require_error("just words", 0, "not a YAML mapping");
  require_error("a: [1, 2\nb: 3\n", 2, "not valid YAML");
  require_error(
      "fx: 500\n", 0,
      "not a camera calibration: read are plumbline (camera), Kalibr and OpenVINS (cam0, relative_config_imucam), "
      "EuRoC (camera_model), OpenCV (camera_matrix), VINS (model_type, cam0_calib), ORB-SLAM (Camera1.fx, "
      "Camera.fx), OKVIS (cameras), Basalt (value0), ROS camera_info (width, k), KITTI (P0, P_rect_00); known "
      "and not read are DepthAI (cameraData) and Maplab (cameras with T_B_C)");
  require_error("camera: 3\n", 1, "camera must be a mapping");
  const std::string missing = message_of([] { read_calibration("/nowhere/calibration.yaml"); });
  REQUIRE(reports(missing, "/nowhere/calibration.yaml", 0, "no such file"));
}

TEST_CASE("calibration: a camera beside an IMU needs the transform, and the IMU is the body") {
  const TemporaryDirectory directory;
  const auto camera = directory.write("camera.yaml", opencv_yaml), imu = directory.write("imu.yaml", kalibr_imu);
  REQUIRE(
      reports(message_of([&] { read_calibration(camera, imu); }), camera, 0, "no transform between camera and IMU"));
  const auto moved =
      directory.write("moved.yaml", kalibr_imu + "T_BS: [1, 0, 0, 0.1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\n");
  const auto euroc_camera = directory.write("euroc.yaml", euroc);
  REQUIRE(reports(message_of([&] { read_calibration(euroc_camera, moved); }), moved, 7, "must be the identity"));
}

TEST_CASE("calibration: Kalibr with the IMU in the same file, as OpenVINS writes it") {
  const std::string imu0 =
      "imu0:\n  T_i_b:\n  - [1.0, 0.0, 0.0, 0.0]\n  - [0.0, 1.0, 0.0, 0.0]\n"
      "  - [0.0, 0.0, 1.0, 0.0]\n  - [0.0, 0.0, 0.0, 1.0]\n"
      "  accelerometer_noise_density: 0.002\n  accelerometer_random_walk: 0.003\n"
      "  gyroscope_noise_density: 0.00017\n  gyroscope_random_walk: 2.0e-05\n"
      "  rostopic: /imu\n  time_offset: 0.0\n  update_rate: 400.0\n  model: kalibr\n";
  const Calibration together = read(kalibr + imu0);
  REQUIRE((together.imu && together.imu->rate_hz == 400 && together.notes.empty()));
  REQUIRE(read(kalibr + imu0 + "  Tw:\n  - [1.0, 0.0, 0.0]\n  - [0.0, 1.0, 0.0]\n  - [0.0, 0.0, 1.0]\n").notes.empty());
  const Calibration scaled =
      read(kalibr + imu0 + "  Tw:\n  - [1.01, 0.0, 0.0]\n  - [0.0, 1.0, 0.0]\n  - [0.0, 0.0, 1.0]\n");
  CAPTURE(scaled.notes.empty() ? std::string() : scaled.notes[0]);
  REQUIRE((scaled.notes.size() == 1 && scaled.notes[0].find(":29: imu0.Tw is not applied") != std::string::npos));
  require_error(kalibr + replaced(imu0, "time_offset: 0.0", "time_offset: 0.01"), 26, "imu0.time_offset must be 0");
  require_error(kalibr + replaced(imu0, "random_walk: 2", "random_wlak: 2"), 24,
                "did you mean \"gyroscope_random_walk\"?");
}

TEST_CASE("calibration: T_imu_cam of OpenVINS is T_body_camera; both directions must agree") {
  const std::string T_imu_cam =
      "  T_imu_cam:\n  - [0, 0, 1, 0.1]\n  - [-1, 0, 0, 0.2]\n  - [0, -1, 0, 0.3]\n  - [0, 0, 0, 1]\n";
  const std::string without = kalibr.substr(0, 6) + kalibr.substr(kalibr.find("  cam_overlaps"));
  REQUIRE((read(without + T_imu_cam).T_body_camera->inverse() * T_forward).log().norm() < 1e-9);
  REQUIRE((read(kalibr + T_imu_cam).T_body_camera->inverse() * T_forward).log().norm() < 1e-9);
  require_error(kalibr + replaced(T_imu_cam, "0.3", "0.4"), 3, "cam0.T_cam_imu is not the inverse of T_imu_cam");
}

TEST_CASE("calibration: what is not read is named") {
  REQUIRE(read(kalibr + "cam1:\n  camera_model: pinhole\n").notes.at(0).find("cam1 is not used: one camera is read") !=
          std::string::npos);
  require_error(replaced(kalibr, "camera_model: pinhole", "camera_model: spline"), 8,
                "known are pinhole, omni, eucm and ds");
}

TEST_CASE("calibration: a lever arm in millimeters") {
  require_error(replaced(plain, "0, 0, 1, 0.1", "0, 0, 1, -64.67"), 0, "is it in millimeters instead of meters?");
  REQUIRE(read(plain).notes.empty());
  REQUIRE(read(replaced(plain, "0, 0, 1, 0.1", "0, 0, 1, 6.4")).notes.at(0).find("is it in meters?") !=
          std::string::npos);
}
