#include "plumbline/io/calibration_writer.hpp"

#include <string>
#include <vector>

#include "catch.hpp"
#include "plumbline/io/calibration.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

struct Model {
  std::string model, distortion;
  std::vector<double> shape, coefficients;
};

const std::vector<Model> models{
    {"pinhole", "none", {}, {}},
    {"pinhole", "radtan", {}, {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05}},
    {"pinhole", "equidistant", {}, {0.0035, 0.0007, -0.002, 0.0002}},
    {"pinhole", "fov", {}, {0.9259487501905697}},
    {"double_sphere", "none", {-0.1792, 0.5912}, {}},
    {"eucm", "none", {0.63, 1.04}, {}},
    {"omni", "radtan", {1.1}, {-0.1, 0.02, 1e-4, -2e-4}},
    {"pinhole", "radtan", {}, {0.262383, -0.953104, -0.005358, 0.002628, 1.163314}},
    {"pinhole", "rational", {}, {0.564, -2.713, 0.0006, -0.0003, 1.537, 0.442, -2.528, 1.463}}};
constexpr std::size_t of_kalibr = 7;  // the others have k3

Calibration calibration_of(const Model& model) {
  Calibration out;
  out.camera.model = model.model;
  out.camera.distortion = model.distortion;
  out.camera.intrinsics = {458.654, 457.296, 367.215, 248.375};
  out.camera.intrinsics.insert(out.camera.intrinsics.end(), model.shape.begin(), model.shape.end());
  out.camera.distortion_coefficients = model.coefficients;
  out.camera.width = 752;
  out.camera.height = 480;
  out.camera.readout_s = 0.026;
  out.T_body_camera = SE3<double>(SO3<double>::exp({0.3, -1.2, 0.8}), {-0.0216, -0.0647, 1.0 / 3});
  out.camera_time_offset_s = -0.0123456789;
  out.imu = ImuNoise{
      .gyro_density = 1.7e-4, .accel_density = 2e-3, .gyro_walk = 1.9393e-5, .accel_walk = 3e-3, .rate_hz = 400};
  out.imu_limits.gyro_full_scale = 17.45;
  return out;
}

void require_equal(const Calibration& a, const Calibration& b) {
  REQUIRE((a.camera.model == b.camera.model && a.camera.distortion == b.camera.distortion));
  REQUIRE(a.camera.intrinsics == b.camera.intrinsics);
  REQUIRE(a.camera.distortion_coefficients == b.camera.distortion_coefficients);
  REQUIRE((a.camera.width == b.camera.width && a.camera.height == b.camera.height));
  REQUIRE(*a.camera.readout_s == Approx(*b.camera.readout_s).epsilon(1e-12));
  REQUIRE((a.T_body_camera->inverse() * *b.T_body_camera).log().norm() < 1e-12);
  REQUIRE(a.camera_time_offset_s == b.camera_time_offset_s);
  REQUIRE((a.imu->gyro_density == b.imu->gyro_density && a.imu->accel_density == b.imu->accel_density));
  REQUIRE((a.imu->gyro_walk == b.imu->gyro_walk && a.imu->accel_walk == b.imu->accel_walk));
  REQUIRE(a.imu->rate_hz == b.imu->rate_hz);
  REQUIRE(a.imu_limits.gyro_full_scale == b.imu_limits.gyro_full_scale);
  REQUIRE(a.imu_limits.accel_full_scale == b.imu_limits.accel_full_scale);
}

Calibration read_again(const WrittenCalibration& written) {
  const TemporaryDirectory directory;
  CAPTURE(written.text);
  return read_calibration(directory.write("written.yaml", written.text));
}

}  // namespace

TEST_CASE("calibration_writer: plain, read again, is the same") {
  for (const Model& model : models) {
    CAPTURE(model.model, model.distortion);
    Calibration calibration = calibration_of(model);
    calibration.depth_scale = 5000;
    calibration.camera.rate_hz = 20;
    const WrittenCalibration written = write_calibration(calibration, "plain");
    REQUIRE(written.lost.empty());
    const Calibration again = read_again(written);
    require_equal(again, calibration);
    REQUIRE((again.depth_scale == 5000 && again.camera.rate_hz == 20));
  }
}

TEST_CASE("calibration_writer: Kalibr, read again, is the same") {
  for (std::size_t i = 0; i < of_kalibr; ++i) {
    CAPTURE(models[i].model, models[i].distortion);
    const Calibration calibration = calibration_of(models[i]);
    const WrittenCalibration written = write_calibration(calibration, "kalibr");
    REQUIRE(written.lost.empty());
    require_equal(read_again(written), calibration);
  }
}

TEST_CASE("calibration_writer: what Kalibr cannot state") {
  for (std::size_t i = of_kalibr; i < models.size(); ++i)
    REQUIRE_THROWS_WITH(write_kalibr(calibration_of(models[i])), Catch::Contains("Kalibr has no distortion with k3"));
  Calibration calibration = calibration_of(models[0]);
  calibration.depth_scale = 1000;
  calibration.camera.rate_hz = 30;
  REQUIRE(write_kalibr(calibration).lost ==
          std::vector<std::string>{"the rate of the images", "the depth scale (give it with --depth-scale 1000)"});
  calibration.T_body_camera.reset();
  calibration.imu.reset();
  REQUIRE(write_kalibr(calibration).lost.size() == 3);
}

TEST_CASE("calibration_writer: the mask, whatever its name") {
  Calibration calibration = calibration_of(models[1]);
  calibration.mask = "/data/it's: a #mask.png";
  const TemporaryDirectory directory;
  REQUIRE(*read_calibration(directory.write("plain.yaml", write_plain(calibration).text)).mask == *calibration.mask);
  const std::vector<std::string> lost = write_kalibr(calibration).lost;
  REQUIRE(lost.back() == "the mask (give it with --mask /data/it's: a #mask.png)");
}
