// What `plumbline doctor` finds out from corners and IMU samples, on a motion that is known.
#include <cmath>
#include <numbers>
#include <vector>

#include "catch.hpp"
#include "epipolar_fit.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "rotation_fit.hpp"
#include "scale_fit.hpp"
#include "statistics.hpp"
#include "still_part.hpp"

using namespace plumbline;

namespace {

using Vector3 = Vec<double, 3>;

const SE3<double> T_imu_cam(SO3<double>::exp({0.4, -1.1, 0.9}), {0.05, -0.02, 0.1});
const Vector3 bias(0.01, -0.02, 0.015), gravity(0, 0, -9.81);
const Pinhole<double> camera{400, 400, 320, 240};
constexpr double begin_s = 2, end_s = 12;

TimeNs ns(double t_s) { return std::llround(1e9 * t_s); }

using Path = SE3<double> (*)(double t_s);

SE3<double> room_path(double t) {
  return SE3<double>(
      SO3<double>::exp(Vector3(0.3 * std::sin(0.9 * t), 0.25 * std::sin(1.3 * t + 1), 0.35 * std::sin(0.7 * t))),
      Vector3(0.8 * std::sin(0.8 * t), 0.6 * std::sin(1.1 * t + 0.5), 0.4 * std::sin(1.4 * t)));
}

/// `sign` of the accelerometer.
std::vector<ImuSample> imu_samples(double sign = 1, bool is_mirrored = false, Path T_world_imu = room_path) {
  constexpr double h = 1e-3;
  std::vector<ImuSample> out;
  for (double t = begin_s - 1; t < end_s + 1; t += 0.005) {
    const SE3<double> T = T_world_imu(t), before = T_world_imu(t - h), after = T_world_imu(t + h);
    ImuSample sample{ns(t), (before.rotation().inverse() * after.rotation()).log() / (2 * h) + bias,
                     sign * (T.rotation().inverse() * ((after.p() - 2 * T.p() + before.p()) / (h * h) - gravity))};
    if (is_mirrored) sample.gyro.x() = -sample.gyro.x();
    out.push_back(sample);
  }
  return out;
}

/// Corners of points in a room, without noise; stamps are late by `late_s`, depth is multiplied by `depth_factor`.
std::vector<TrackedFrame> tracked_frames(double late_s, double depth_factor) {
  Random random(3);
  std::vector<Vector3> points;
  points.reserve(1500);
  for (int i = 0; i < 1500; ++i)
    points.push_back(
        Vector3(2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1).normalized() *
        (3 + 3 * random.uniform()));
  std::vector<TrackedFrame> out;
  for (double t = begin_s; t < end_s; t += 0.05) {
    TrackedFrame frame{ns(t + late_s), !out.empty(), {}};
    const SE3<double> T_cam_world = (room_path(t) * T_imu_cam).inverse();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector3 p = T_cam_world * points[i];
      const Projection<double> pixel = camera.project(p);
      if (!pixel.valid || pixel.uv.x() < 0 || pixel.uv.x() > 639 || pixel.uv.y() < 0 || pixel.uv.y() > 479) continue;
      frame.corners.push_back({std::uint32_t(i), pixel.uv, p.normalized(), depth_factor * p.z()});
    }
    out.push_back(frame);
  }
  return out;
}

/// Along a wall and turned towards where it goes, at rest for an instant at 5 s.
SE3<double> wall_path(double t) {
  const double s = t + std::sin(0.2 * std::numbers::pi * t) / (0.2 * std::numbers::pi);
  const SO3<double> R =
      SO3<double>::exp(Vector3(0.06 * std::sin(1.2 * s), 0.6 * std::sin(0.75 * s + 0.2), 0.04 * std::sin(1.1 * s)));
  return SE3<double>(R, Vector3(0.25 * std::sin(0.75 * s), 0.1 * std::sin(1.1 * s), 0.1 * std::sin(0.5 * s))) *
         T_imu_cam.inverse();
}

/// Corners on a round wall with a relief of 0.2 m that fills an image of 320 x 256 pixels, with noise.
std::vector<TrackedFrame> frames_of_wall(double late_s, double noise_px) {
  const Pinhole<double> small{268, 268, 160, 128};
  testing::Gaussian random(5);
  const auto uniform = [&] { return random.random().uniform(); };
  std::vector<Vector3> points;
  points.reserve(2500);
  for (int i = 0; i < 2500; ++i) {
    const double angle = 3 * uniform() - 1.5, range = 2 + 0.2 * uniform();
    points.emplace_back(range * std::sin(angle), 5 * uniform() - 2.5, range * std::cos(angle));
  }
  std::vector<TrackedFrame> out;
  for (double t = begin_s; t < end_s; t += 0.05) {
    TrackedFrame frame{ns(t + late_s), !out.empty(), {}};
    const SE3<double> T_cam_world = (wall_path(t) * T_imu_cam).inverse();
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Projection<double> pixel = small.project(T_cam_world * points[i]);
      if (!pixel.valid || !(std::abs(pixel.uv.x() - 160) < 160) || !(std::abs(pixel.uv.y() - 128) < 128)) continue;
      const Vec<double, 2> uv = pixel.uv + noise_px * random.vector<2>();
      frame.corners.push_back({std::uint32_t(i), uv, small.unproject(uv).bearing, 0});
    }
    out.push_back(frame);
  }
  return out;
}

double median_scale(double sign, bool with_depth) {
  std::vector<double> scales;
  const CameraOnImu camera_on_imu{T_imu_cam, -0.1, bias};
  for (const WindowScale& window :
       fit_scales(tracked_frames(0.1, 0.5), imu_samples(sign), camera_on_imu, with_depth, 400)) {
    CHECK(window.gravity == Approx(9.81).margin(0.2));
    scales.push_back(window.scale);
  }
  CHECK(scales.size() > 5);
  return median(scales);
}

}  // namespace

TEST_CASE("motion_check: time offset, rotation and bias of the gyroscope") {
  const RotationFit fit = fit_rotation(image_rates_of(tracked_frames(0.237, 1), 400), imu_samples());
  REQUIRE(fit.has_rotation());
  CHECK(fit.time_offset_s == Approx(-0.237).margin(0.001));
  CHECK((fit.R_imu_cam.inverse() * T_imu_cam.rotation()).log().norm() < 0.005);
  CHECK((fit.gyro_bias - bias).norm() < 0.003);
  CHECK(fit.slope == Approx(1).margin(0.01));
  CHECK((fit.sigma_offset_s > 0 && fit.sigma_offset_s < 0.002));
  CHECK(!fit.is_mirrored());
  CHECK(fit_rotation(image_rates_of(tracked_frames(0, 1), 400), imu_samples(1, true)).is_mirrored());
}

TEST_CASE("motion_check: a motion along a wall that fills the image is no rotation") {
  for (const double noise_px : {0.05, 0.2}) {
    const std::vector<TrackedFrame> frames = frames_of_wall(0.4, noise_px);
    const std::vector<ImuSample> samples = imu_samples(1, false, wall_path);
    CHECK(268 * corner_noise(frames, 268) == Approx(noise_px).epsilon(0.3));
    const std::vector<ImageRate> rates = image_rates_of(frames, 268);
    const RotationFit coarse = fit_rotation(rates, samples);
    REQUIRE(coarse.has_rotation());
    CHECK(coarse.slope == Approx(1).margin(0.03));
    const auto fit = fit_epipolar(frames, rates, samples, coarse, 268);
    REQUIRE(fit);
    CHECK(fit->time_offset_s == Approx(-0.4).margin(0.001));
    CHECK((fit->sigma_offset_s > 0 && fit->sigma_offset_s < 0.0005 + 0.02 * noise_px));
    CHECK((fit->R_imu_cam.inverse() * T_imu_cam.rotation()).log().norm() < 0.003);
    CHECK((fit->gyro_bias - bias).norm() < 0.02 * noise_px);
    CHECK(268 * fit->noise_rad == Approx(noise_px).epsilon(0.15));
  }
}

TEST_CASE("motion_check: samples that cover few of the images give no fit") {
  const std::vector<TrackedFrame> frames = frames_of_wall(0, 0.1);
  const std::vector<ImageRate> rates = image_rates_of(frames, 268);
  std::vector<ImuSample> samples = imu_samples(1, false, wall_path);
  const RotationFit coarse = fit_rotation(rates, samples);
  CHECK(fit_epipolar(frames, rates, samples, coarse, 268).has_value());
  samples.resize(samples.size() / 2);
  CHECK(!fit_epipolar(frames, rates, samples, coarse, 268).has_value());
  CHECK(!fit_epipolar(frames, rates, {}, coarse, 268).has_value());
  CHECK(!fit_epipolar({}, {}, samples, coarse, 268).has_value());
}

TEST_CASE("motion_check: scale of depth, and the sign of the accelerometer with and without it") {
  CHECK(median_scale(1, true) == Approx(2).epsilon(0.03));  // depth is half of what it should be
  CHECK(median_scale(-1, true) == Approx(-2).epsilon(0.03));
  CHECK(median_scale(1, false) > 0);
  CHECK(median_scale(-1, false) < 0);
}

TEST_CASE("motion_check: the part of the image that does not move while the camera turns") {
  io::CameraCalibration calibration;
  calibration.intrinsics = {400, 400, 320, 240};
  calibration.width = 640;
  calibration.height = 480;
  std::vector<TrackedFrame> frames = tracked_frames(0, 1);
  const std::vector<ImageRate> rates = image_rates_of(frames, 400);
  CHECK(find_still_part(frames, rates, calibration).share == 0);
  for (TrackedFrame& frame : frames) {  // a grid over the lower quarter, and nothing else there
    std::erase_if(frame.corners, [](const TrackedCorner& corner) { return corner.uv.y() >= 360; });
    std::uint32_t id = 10'000;
    for (int y = 365; y < 480; y += 20)
      for (int x = 5; x < 640; x += 20) {
        const Vec<double, 2> uv(x, y);
        frame.corners.push_back({id++, uv, camera.unproject(uv).bearing, 0});
      }
  }
  const StillPart part = find_still_part(frames, rates, calibration);
  CHECK(part.share == Approx(0.25).margin(0.02));
  CHECK((part.left == 0 && part.right == 640 && part.top == 360 && part.bottom == 480));
}
