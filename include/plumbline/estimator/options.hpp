#pragma once
/// What can be set about an estimator, by name. Defaults suit a sensor class, never a recording.
///
///   Vio::Options options;
///   options.points.target_count = 120;

#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/estimator/recovery.hpp"
#include "plumbline/feature/motion_estimate.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/state/readout_belief.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

/// Beside these, the options of each kind under its name: `points`, `lines`, `start_points`.
template <class Parts>
struct EstimatorOptions : Parts::FrontEnds::Options {
  MotionOptions pose;  ///< of one frame, its map being given
  KeyframeOptions keyframe = default_keyframes<typename Parts::Sensors>();
  PoseRansacOptions ransac;
  typename Parts::Backend::Options backend;
  typename Parts::Motion::Options motion;
  typename Parts::Start::Options start;
  RotationAlignmentOptions rotation;
  ReadoutOptions readout;
  RecoveryOptions recovery = default_recovery<typename Parts::Sensors>();
  double calibration_error = 0.002;  ///< what no residual shows, of the angle turned and the way travelled
};

}  // namespace plumbline
