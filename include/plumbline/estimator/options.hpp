#pragma once
/// What can be set about an estimator, by name. Defaults suit a sensor class, never a recording.
///
///   Vio::Options options;
///   options.points.target_count = 120;

#include "plumbline/backend/keyframe_rule.hpp"
#include "plumbline/feature/motion_estimate.hpp"
#include "plumbline/geometry/pose_ransac.hpp"
#include "plumbline/state/readout_filter.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

/// When images are of no use.
struct RecoveryOptions {
  int min_landmarks = 15;     ///< to begin with, or to go on with
  int max_lost_frames = 20;   ///< of a camera alone that show something, tried again before all begins anew
  double gap_s = 0.2;         ///< without an image of use: after it the camera may have turned by anything
  int max_blind_frames = 3;   ///< in a row that the IMU bridges, before new landmarks are looked for
  double max_coasting_s = 3;  ///< on the IMU alone, or waiting for a sight known, before all begins anew
  double lost_speed = 1;      ///< of a body that nothing tells of, sigma [m/s]
  double lost_rate = 1;       ///< [rad/s]
};

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
  RecoveryOptions recovery;
  double calibration_error = 0.002;  ///< what no residual shows, of the angle turned and the way travelled
};

}  // namespace plumbline
