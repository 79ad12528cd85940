#pragma once
/// The scale of what the images show, from the accelerometer: 1 for depth in meters, negative where the accelerometer
/// has the reversed sign. Over a second or two, with points from depth, or from two views with a translation of length
/// 1:
///
///   u_k = (v t_k + g t_k^2/2 + alpha_k + (R_k - I) l)/s       unknown: 1/s, v/s, g/s: the noise is that of u
/// u_k: way of the camera in the images, in the axes of the IMU at the begin; alpha_k: twice integrated specific force;
/// R_k: rotation of the IMU; l: the camera in the IMU frame. A constant bias of the accelerometer is part of g.

#include <vector>

#include "corner_tracks.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/lie/so3.hpp"

/// How camera and IMU are to each other, as far as the images tell or the calibration states.
struct CameraOnImu {
  plumbline::SE3<double> T_imu_cam;
  double time_offset_s;  ///< IMU time = frame time + offset
  plumbline::Vec<double, 3> gyro_bias;
};

struct WindowScale {
  double scale, sigma;
  double gravity;  ///< [m/s^2]
};

/// Of the windows in which enough points are followed; with depth `scale` is 1, without it only its sign means
/// something.
std::vector<WindowScale> fit_scales(const std::vector<TrackedFrame>& frames,
                                    const std::vector<plumbline::ImuSample>& samples, const CameraOnImu& camera,
                                    bool with_depth, double focal_length_px);
