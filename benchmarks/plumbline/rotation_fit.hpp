#pragma once
/// The rotation and the time between a camera and a gyroscope, from the rotation of the images: of all time offsets the
/// one whose mean angular rates, turned by the best rotation, are nearest to those of the images. A constant difference
/// is the gyroscope's bias.
///
///   c_k: rate of the images between two frames, w_k(d): mean rate of the gyroscope between their times plus d
///   H = sum (c_k - c_mean)(w_k - w_mean)^T = U S V^T,  R_cam_imu = U diag(1, 1, det) V^T
///   correlation = (s_1 + s_2 + det s_3)/sqrt(sum |c_k - c_mean|^2 sum |w_k - w_mean|^2)

#include <cstddef>
#include <vector>

#include "corner_tracks.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/lie/so3.hpp"

/// Mean angular rate of the camera between two frames, in the camera [rad/s].
struct ImageRate {
  plumbline::TimeNs begin_ns, end_ns;
  plumbline::Vec<double, 3> rate;
  std::size_t first, second;  ///< the frames
};

/// The flow ends with steps below it: corners are not better located.
inline constexpr double least_noise_px = 0.02;

/// Median noise of a corner [rad] over pairs of frames. With more than that a motion along a wall that fills the image
/// is taken for a rotation, which is the simpler model.
double corner_noise(const std::vector<TrackedFrame>& frames, double focal_length_px);

/// From each frame, or each second or third of many, to the one after it in which the corners have moved far enough,
/// where they fit one motion.
std::vector<ImageRate> image_rates_of(const std::vector<TrackedFrame>& frames, double focal_length_px);

/// Integral of the gyroscope over time [rad].
class GyroscopeIntegral {
 public:
  explicit GyroscopeIntegral(const std::vector<plumbline::ImuSample>& samples);
  bool covers(plumbline::TimeNs begin_ns, plumbline::TimeNs end_ns) const;
  /// Both times must be covered.
  plumbline::Vec<double, 3> mean_rate(plumbline::TimeNs begin_ns, plumbline::TimeNs end_ns) const;

 private:
  plumbline::Vec<double, 3> at(plumbline::TimeNs t_ns) const;

  std::vector<plumbline::TimeNs> times_;
  std::vector<plumbline::Vec<double, 3>> integral_;
};

struct RotationFit {
  std::size_t rates = 0;            ///< pairs of frames that count
  double rms_rate = 0;              ///< of the images, about their mean [rad/s]
  double correlation = 0;           ///< 1: the same but for the noise
  double mirrored_correlation = 0;  ///< where one axis is reversed
  double time_offset_s = 0;         ///< IMU time = image time + offset
  double sigma_offset_s = 0;        ///< of it
  double sigma_rad = 0;             ///< of the rotation about its least certain axis
  double slope = 0;                 ///< rate of the images by that of the gyroscope
  plumbline::SO3<double> R_imu_cam;
  plumbline::Vec<double, 3> gyro_bias = plumbline::Vec<double, 3>::Zero();

  /// Whether one axis is reversed: then the others are nothing.
  bool is_mirrored() const {
    return rates >= 30 && rms_rate > 0.03 && mirrored_correlation > 0.95 &&
           1 - correlation > 5 * (1 - mirrored_correlation);
  }
  /// Whether the time offset is known; whether the rotation is, too.
  bool has_offset() const { return rates >= 30 && rms_rate > 0.03 && correlation > 0.95; }
  bool has_rotation() const { return has_offset() && sigma_rad < 0.02; }
};

RotationFit fit_rotation(const std::vector<ImageRate>& rates, const std::vector<plumbline::ImuSample>& samples);
