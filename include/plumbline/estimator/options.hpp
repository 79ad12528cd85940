#pragma once
/// Options of an estimator, by component. Defaults are those of a sensor class, not of a recording.
///
///   Vio::Options options;
///   options.points.target_count = 120;

#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/estimator/recovery_options.hpp"
#include "plumbline/feature/pose_refinement.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/state/readout_estimate.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

/// Options of the components. Each feature kind adds its own: `points`, `lines`, `initialization_points`.
template <class Parts>
struct EstimatorOptions : Parts::FrontEnds::Options {
  PoseRefinementOptions pose;  ///< motion-only pose estimation
  KeyframeOptions keyframe = default_keyframes<typename Parts::Sensors>();
  PoseRansacOptions ransac;
  typename Parts::Backend::Options backend;
  typename Parts::Propagation::Options propagation;
  typename Parts::Initializer::Options initialization;
  RotationAlignmentOptions rotation;
  ReadoutOptions readout;
  RecoveryOptions recovery = default_recovery<typename Parts::Sensors>();
  /// Of angle and distance, relative; not seen in residuals; tuned: docs/decisions/013.
  double calibration_error = 0.002;
};

}  // namespace plumbline
