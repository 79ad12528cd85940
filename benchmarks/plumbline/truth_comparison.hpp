#pragma once
/// How far poses are from the truth, and whether that is consistent with their covariances.

#include <optional>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/io/trajectory.hpp"
#include "plumbline/lie/so3.hpp"

struct EstimatedPose {
  plumbline::TimeNs t_ns;
  plumbline::SE3<double> T_world_body;
  plumbline::Mat<double, 6, 6> covariance;  ///< of [dphi, dp], right increments
};

/// Of one pose. The error e = minus(truth, estimate) [dphi, dp] is that after aligning all poses. NEES, e^T P^-1 e, has
/// the truth aligned at the first pose instead, which is where the covariances count from (positions with an IMU:
/// turned by `heading`): 6 is expected of a pose, 3 of its parts; NaN where P is not positive definite.
struct TruthError {
  plumbline::TimeNs t_ns;
  plumbline::Vec<double, 6> error;
  double nees_rotation, nees_position, nees_pose;
};

struct TruthComparison {
  std::vector<TruthError> errors;
  /// Turns true positions to true attitudes, which may be a degree off: the heading of the first pose becomes that of
  /// all positions. The identity where these determine it badly.
  plumbline::SO3<double> heading;
};

/// The truth is interpolated; poses without it within 0.1 s are left out. What is aligned is position and heading where
/// `gravity_is_known`, else the whole pose. `heading`: that of another run with a better estimate.
TruthComparison compare_with_truth(const plumbline::io::Trajectory& truth, const std::vector<EstimatedPose>& estimates,
                                   bool gravity_is_known,
                                   const std::optional<plumbline::SO3<double>>& heading = std::nullopt);

/// Interpolated; nothing where the poses around the time are 0.1 s apart or more.
std::optional<plumbline::SE3<double>> truth_at(const plumbline::io::Trajectory& truth, plumbline::TimeNs t_ns);

/// Root mean square of the distances [m].
double position_rmse(const std::vector<TruthError>& errors);
