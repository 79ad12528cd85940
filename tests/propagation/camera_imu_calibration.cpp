#include "plumbline/propagation/camera_imu_calibration.hpp"

#include "catch.hpp"
#include "propagation/steady_samples.hpp"

using namespace plumbline;

namespace {
struct Rig {
  SE3<double> extrinsics{SO3<double>::exp({0.1, 0, 0}), Vec<double, 3>(0.1, 0.2, 0.3)};
  struct {
    double camera_time_offset_s = 0.01;
  } imu;
  double time_offset_s = 0.01;
  const SE3<double>& T_body_cam() const { return extrinsics; }
  void set_T_body_cam(const SE3<double>& T) { extrinsics = T; }
  void set_time_offset(double offset_s) { time_offset_s = offset_s; }
};
/// Estimates of a window.
struct Window {
  bool estimates = false;
  SE3<double> found{SO3<double>::exp({0.12, 0, 0}), Vec<double, 3>(0.1, 0.2, 0.35)};
  double offset_s = 0.013;
  const SE3<double>& T_body_cam(const SE3<double>& calibrated) const { return estimates ? found : calibrated; }
  double time_offset_s(double in_use_s) const { return estimates ? offset_s : in_use_s; }
};
}  // namespace

TEST_CASE("camera_imu_calibration: what the window finds is in force for rig and samples, and a reset takes it back") {
  Rig rig;
  Window window;
  test::SteadySamples<double> samples;
  CameraImuCalibration<double> calibration(rig, CameraImuOptions{});
  const SE3<double> calibrated = rig.extrinsics;
  CHECK(calibration.apply(rig, window, true, 0.002, samples.imu) == 0.01);
  CHECK((rig.extrinsics.p() - calibrated.p()).norm() == 0);
  window.estimates = true;
  CHECK(calibration.apply(rig, window, true, 0.002, samples.imu) == Approx(0.012));  // a step at most
  CHECK(calibration.apply(rig, window, true, 0.002, samples.imu) == Approx(0.013));
  CHECK(rig.time_offset_s == Approx(0.013));
  CHECK(samples.imu.time_of(0) == Approx(13e6).margin(2));
  CHECK((rig.extrinsics.p() - window.found.p()).norm() == 0);

  calibration.restart();
  window.estimates = false;
  CHECK(calibration.apply(rig, window, false, 0.002, samples.imu) == Approx(0.01));
  CHECK((rig.extrinsics.p() - calibrated.p()).norm() == 0);
}

TEST_CASE("camera_imu_calibration: as prior of the window the time offset is fixed where it is calibrated") {
  Rig rig;
  const CameraImuCalibration<double> calibration(rig, CameraImuOptions{});
  CHECK(calibration.estimate(true, 1e-3).is_known);
  CHECK_FALSE(calibration.estimate(false, 1e-3).is_known);
  CHECK(calibration.estimate(false, 1e-3).offset_s == 0.01);
}
