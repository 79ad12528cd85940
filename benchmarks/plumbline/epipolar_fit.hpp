#pragma once
/// Time, rotation and gyroscope bias between a camera and an IMU from the corners themselves: for all pairs of frames
/// together, the maximum of the likelihood of their epipolar errors. Each pair has a translation of its own; rotations
/// are those of the gyroscope. A rotation of a single pair is hardly told from a translation across a wall that fills
/// the image; all pairs have one offset, one rotation and one bias, which no translation imitates.
///
///   R_21(d, R, b) = R^T D^T R,  D: rotation of the gyroscope less b from t_1 + d to t_2 + d,  R = R_imu_cam
///   r = t . (R_21 f1 x f2) / s,  s: Sampson's norm of the derivatives by f1 and f2,  |t| = 1
///   D <- D Exp(phi):  dphi/dd = w_2 - D^T w_1,  dphi/db = -R_2^T int R(tau) dtau
/// Cauchy's loss, its scale by the median of |r|; the translations are eliminated (Schur complement). The covariance is
/// that of clustered errors, H^-1 (sum g_c g_c^T) H^-1 with the gradients g_c of the seconds c: pairs share corners,
/// and corners that slide along edges do so for a while.

#include <optional>
#include <vector>

#include "corner_tracks.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/imu/sample.hpp"
#include "plumbline/lie/so3.hpp"
#include "rotation_fit.hpp"

struct EpipolarFit {
  double time_offset_s = 0, sigma_offset_s = 0;  ///< IMU time = image time + offset
  plumbline::SO3<double> R_imu_cam;
  plumbline::Vec<double, 3> gyro_bias = plumbline::Vec<double, 3>::Zero();
  double noise_rad = 0;  ///< of one bearing
};

/// From a start that is near, such as fit_rotation's, over the pairs of frames of `rates`. Nothing where the iteration
/// does not converge, or the samples cover too few of the pairs.
std::optional<EpipolarFit> fit_epipolar(const std::vector<TrackedFrame>& frames, const std::vector<ImageRate>& rates,
                                        const std::vector<plumbline::ImuSample>& samples, const RotationFit& start,
                                        double focal_length_px);
