#pragma once
/// How far poses are from the truth, and whether their covariances say so.

#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/io/trajectory.hpp"

struct EstimatedPose {
  plumbline::TimeNs t_ns;
  plumbline::SE3<double> T_world_body;
  plumbline::Mat<double, 6, 6> covariance;  ///< of [dphi, dp], right increments
};

/// Of one pose. The error e = minus(truth, estimate) [dphi, dp] is that after aligning all poses. NEES, e^T P^-1 e, has
/// the truth aligned at the first pose instead, which is where the covariances count from (positions with an IMU and
/// some metres of path: with the heading of all of them): 6 is expected of a pose, 3 of its parts; NaN where P is not
/// positive definite.
struct TruthError {
  plumbline::TimeNs t_ns;
  plumbline::Vec<double, 6> error;
  double nees_rotation, nees_position, nees_pose;
};

/// The truth is interpolated; poses without it within 0.1 s are left out. What is aligned is position and heading where
/// `gravity_is_known`, else the whole pose.
std::vector<TruthError> compare_with_truth(const plumbline::io::Trajectory& truth,
                                           const std::vector<EstimatedPose>& estimates, bool gravity_is_known);

/// Root mean square of the distances [m].
double position_rmse(const std::vector<TruthError>& errors);
