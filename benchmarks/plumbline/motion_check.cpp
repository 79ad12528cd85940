#include "motion_check.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "epipolar_fit.hpp"
#include "format.hpp"
#include "plumbline/io/make_camera.hpp"
#include "rotation_fit.hpp"
#include "scale_fit.hpp"
#include "statistics.hpp"
#include "still_part.hpp"

namespace pl = plumbline;
namespace io = plumbline::io;

namespace {

using Matrix3 = pl::Mat<double, 3, 3>;
using SO3 = pl::SO3<double>;
using Diagnoses = std::vector<Diagnosis>;

double angle_deg(const SO3& R) { return R.log().norm() * degrees; }

void check_corners(const std::vector<TrackedFrame>& frames, Diagnoses& out) {
  std::vector<double> followed;
  for (std::size_t i = 1; i < frames.size(); ++i)
    if (frames[i].follows) followed.push_back(double(pairs_of(frames[i - 1], frames[i]).size()));
  const double middle = median(followed), low = percentile(followed, 0.1);
  if (followed.empty()) return;
  const std::string text =
      format("%.0f corners are followed from frame to frame, less than %.0f in 1 of 10 frames", middle, low);
  if (middle < 30)
    out.push_back({DiagnosisLevel::warning, "corners", text + ": blurred, dark, or little to see?"});
  else
    out.push_back({DiagnosisLevel::ok, "corners", text});
}

void check_still_part(const StillPart& part, Diagnoses& out) {
  if (part.share < 0.02) return;
  const std::string text = format(
      "%.0f %% of the image does not move while the camera turns, within x %d to %d, y %d to %d px: part of the "
      "vehicle, or dirt? Exclude it by --mask FILE, a gray image that is zero there",
      100 * part.share, part.left, part.right, part.top, part.bottom);
  out.push_back({part.share < 0.1 ? DiagnosisLevel::warning : DiagnosisLevel::error, "still part", text});
}

void check_offset(const io::Recording& recording, const RotationFit& fit, Diagnoses& out) {
  const double d = fit.time_offset_s, used = recording.has_imu() ? recording.calibration().camera_time_offset_s : 0;
  const double readout_s = recording.calibration().camera.readout_s.value_or(0);  // corners are of different rows
  const double known_to_s = std::max({0.01, 5 * fit.sigma_offset_s, readout_s});
  const std::string text = format("images and gyroscope turn together where images are taken %.1f ms %s",
                                  std::abs(d) * 1e3, d > 0 ? "later than stamped" : "earlier than stamped");
  if (std::abs(d) < known_to_s) {
    const bool is_known = known_to_s < 0.03;
    out.push_back({is_known ? DiagnosisLevel::ok : DiagnosisLevel::note, "time offset",
                   text + (is_known ? "" : format(", known to %.0f ms only", known_to_s * 1e3))});
    return;
  }
  out.push_back({std::abs(d) > 0.05 ? DiagnosisLevel::error : DiagnosisLevel::warning, "time offset",
                 text + format(": give --time-offset %.3f (time_offset_s, timeshift_cam_imu)", used + d)});
}

/// The nearest of the 24 rotations that map axes to axes.
SO3 nearest_axes(const SO3& R) {
  SO3 best;
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      for (int signs = 0; signs < 4 && i != k; ++signs) {
        Matrix3 M = Matrix3::Zero();
        M(i, 0) = signs & 1 ? -1 : 1;
        M(k, 1) = signs & 2 ? -1 : 1;
        M.col(2) = M.col(0).cross(M.col(1));
        const SO3 candidate = SO3::from_matrix(M);
        if (angle_deg(candidate.inverse() * R) < angle_deg(best.inverse() * R)) best = candidate;
      }
  return best;
}

/// "turned by 90 degrees about the optical axis"
std::string turn_of(const SO3& R) {
  constexpr std::array<const char*, 3> axes{"the x axis of the camera (right)", "the y axis of the camera (down)",
                                            "the optical axis"};
  const pl::Vec<double, 3> w = R.log();
  Eigen::Index axis = 0;
  const double along = w.cwiseAbs().maxCoeff(&axis);
  if (along > 0.98 * w.norm())
    return format("turned by %.0f degrees about %s", w[axis] * degrees, axes[std::size_t(axis)]);
  return format("turned by %.0f degrees about the axis (%.2f %.2f %.2f) of the camera", w.norm() * degrees,
                w.x() / w.norm(), w.y() / w.norm(), w.z() / w.norm());
}

void check_rotation(const io::Recording& recording, const RotationFit& fit, Diagnoses& out) {
  if (fit.is_mirrored()) {
    out.push_back(
        {DiagnosisLevel::error, "gyroscope",
         format("one axis of the gyroscope, or all three, have the reversed sign: the images turn like the mirrored "
                "samples (correlation %.3f instead of %.3f)",
                fit.mirrored_correlation, fit.correlation)});
    return;
  }
  if (!fit.has_rotation()) {
    out.push_back(
        {DiagnosisLevel::note, "extrinsics",
         format("the rotation between camera and IMU is known to %.0f degrees only: turn about all axes, in front of "
                "things with texture",
                5 * fit.sigma_rad * degrees)});
    return;
  }
  if (!recording.calibration().T_body_camera) {
    const Matrix3 R = fit.R_imu_cam.matrix();
    out.push_back(
        {DiagnosisLevel::note, "extrinsics",
         format("the calibration has no transform; the rotation of T_body_camera is about [%.3f %.3f %.3f; %.3f %.3f "
                "%.3f; %.3f %.3f %.3f]",
                R(0, 0), R(0, 1), R(0, 2), R(1, 0), R(1, 1), R(1, 2), R(2, 0), R(2, 1), R(2, 2))});
    return;
  }
  const SO3 stated = recording.calibration().T_body_camera->rotation(), off = stated.inverse() * fit.R_imu_cam;
  const double angle = angle_deg(off);
  std::string text = format(
      "the images turn as the gyroscope says within %.1f degrees of the stated rotation between camera and IMU", angle);
  if (angle < 4) {
    out.push_back({DiagnosisLevel::ok, "extrinsics", text});
    return;
  }
  text = format("the stated rotation between camera and IMU is off by %.0f degrees: ", angle);
  const SO3 axes = nearest_axes(off);
  if (angle_deg(stated * fit.R_imu_cam) < 6)
    text +=
        "the inverse of the stated transform fits (T_cam_imu is camera from IMU, T_imu_cam and T_BS are IMU from "
        "camera)";
  else if (angle_deg(axes) > 1 && angle_deg(axes.inverse() * off) < 6)
    text += "the camera is " + turn_of(axes) + " against it";
  else
    text += "the camera is " + turn_of(off) + " against it";
  out.push_back({angle > 10 ? DiagnosisLevel::error : DiagnosisLevel::warning, "extrinsics", text});
}

void check_slope(const RotationFit& fit, Diagnoses& out) {
  if (fit.slope > 0.85 && fit.slope < 1.15) return;
  out.push_back(
      {DiagnosisLevel::warning, "intrinsics",
       format(
           "the images turn %.2f times as fast as the gyroscope: are the focal lengths those of this resolution, and "
           "the gyroscope in rad/s?",
           fit.slope)});
}

void check_depth_scale(const io::Recording& recording, const std::vector<double>& scales, Diagnoses& out) {
  const double scale = median(scales), stated = recording.calibration().depth_scale, found = stated / scale;
  if (scale > 0.85 && scale < 1.18) {
    out.push_back({DiagnosisLevel::ok, "depth scale",
                   format("the accelerometer confirms it: %.2f of the stated one", found / stated)});
    return;
  }
  std::string text = format("by the accelerometer a value of %.3g is 1 m, the calibration states %g", found, stated);
  for (const double usual : {1000.0, 5000.0, 256.0, 4000.0, 10000.0})
    if (std::abs(std::log(found / usual)) < std::log(1.15)) text += format(": --depth-scale %g?", usual);
  out.push_back({scale > 0.7 && scale < 1.4 ? DiagnosisLevel::warning : DiagnosisLevel::error, "depth scale", text});
}

/// The sign of the accelerometer, and the scale of depth.
void check_scale(const io::Recording& recording, const std::vector<TrackedFrame>& frames, const RotationFit& fit,
                 double focal_length_px, Diagnoses& out) {
  constexpr double least_sigmas = 8, gravity = 9.81, most_off = 0.8;
  const pl::Vec<double, 3> lever =
      recording.calibration().T_body_camera ? recording.calibration().T_body_camera->p() : pl::Vec<double, 3>::Zero();
  const CameraOnImu camera{{fit.R_imu_cam, lever}, fit.time_offset_s, fit.gyro_bias};
  std::vector<double> scales;
  for (const WindowScale& window : fit_scales(frames, recording.imu(), camera, recording.has_depth(), focal_length_px))
    if (std::abs(window.scale) > least_sigmas * window.sigma && std::abs(window.gravity - gravity) < most_off)
      scales.push_back(window.scale);
  if (scales.size() < 4) {
    out.push_back({DiagnosisLevel::note, "accelerometer",
                   "its sign cannot be told: too little acceleration while enough is followed"});
    return;
  }
  const auto negative = double(std::count_if(scales.begin(), scales.end(), [](double scale) { return scale < 0; }));
  const double share = negative / double(scales.size());
  if (share > 0.8) {
    out.push_back({DiagnosisLevel::error, "accelerometer",
                   format("the sign of the accelerometer is reversed: in %.0f of %zu windows the images accelerate the "
                          "other way; at "
                          "rest and level it must measure (0, 0, +9.81) along the axis that points up",
                          negative, scales.size())});
    return;
  }
  if (share > 0.2) {
    out.push_back({DiagnosisLevel::note, "accelerometer",
                   format("its sign cannot be told: %.0f of %zu windows disagree", negative, scales.size())});
    return;
  }
  out.push_back({DiagnosisLevel::ok, "accelerometer",
                 format("the images accelerate as it says, in %.0f of %zu windows", double(scales.size()) - negative,
                        scales.size())});
  if (recording.has_depth()) check_depth_scale(recording, scales, out);
}

/// By the rotation of the images, then by the corners themselves.
RotationFit fit_gyroscope(const std::vector<TrackedFrame>& frames, const std::vector<ImageRate>& rates,
                          const io::Recording& recording, double focal_length_px) {
  RotationFit out = fit_rotation(rates, recording.imu());
  if (!out.has_offset() || out.is_mirrored()) return out;
  const auto fit = fit_epipolar(frames, rates, recording.imu(), out, focal_length_px);
  if (!fit) return out;
  out.time_offset_s = fit->time_offset_s;
  out.sigma_offset_s = fit->sigma_offset_s;
  out.R_imu_cam = fit->R_imu_cam;
  out.gyro_bias = fit->gyro_bias;
  return out;
}

}  // namespace

std::vector<Diagnosis> check_motion(const io::Recording& recording, const std::vector<TrackedFrame>& frames,
                                    bool with_imu) {
  Diagnoses out;
  if (!can_track(recording.calibration().camera)) {
    out.push_back({DiagnosisLevel::note, "corners",
                   "images of this size are not followed: time offset and extrinsics are not checked"});
    return out;
  }
  check_corners(frames, out);
  const double focal_length_px = pl::effective_focal_length(io::make_camera<double>(recording.calibration().camera));
  const std::vector<ImageRate> rates = image_rates_of(frames, focal_length_px);
  check_still_part(find_still_part(frames, rates, recording.calibration().camera), out);
  if (!with_imu || recording.imu().empty()) return out;
  const RotationFit fit = fit_gyroscope(frames, rates, recording, focal_length_px);
  if (!fit.has_offset() && !fit.is_mirrored()) {
    const bool turns = fit.rates >= 30 && fit.rms_rate > 0.1;
    out.push_back(
        {turns ? DiagnosisLevel::warning : DiagnosisLevel::note, "gyroscope",
         turns
             ? format(
                   "the images do not turn as the gyroscope says (correlation %.2f, expected above 0.95), whatever the "
                   "rotation between them and the time offset up to 0.6 s",
                   fit.correlation)
             : format(
                   "time offset and rotation between camera and IMU cannot be told: the images turn with %.3f rad/s, "
                   "0.03 or more is needed",
                   fit.rms_rate)});
    return out;
  }
  check_offset(recording, fit, out);
  check_rotation(recording, fit, out);
  if (fit.is_mirrored()) return out;
  check_slope(fit, out);
  if (fit.has_rotation()) check_scale(recording, frames, fit, focal_length_px, out);
  return out;
}
