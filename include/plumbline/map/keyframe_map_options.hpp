#pragma once
/// Options of a keyframe map.                                                                  docs/math/map.md

#include "plumbline/map/frame_localizer.hpp"
#include "plumbline/map/local_adjustment.hpp"
#include "plumbline/map/loop_alignment.hpp"
#include "plumbline/map/loop_gate.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/map/place_pose.hpp"
#include "plumbline/map/point_recall.hpp"
#include "plumbline/tracking/orb_features.hpp"

namespace plumbline {

struct KeyframeMapOptions {
  PlaceGraphOptions graph;
  PlacePoseOptions pose;
  OrbFeatureOptions features;
  LoopAlignmentOptions alignment;
  LoopGateOptions gate{.rejected_share = 1e-4, .covariance_inflation = 1};
  bool localize_only = false;  ///< the map that was taken in is not changed
  float min_score = 0.003f;    ///< of a candidate, place_recognition.md (12)
  /// Relative error that all ranges of a keyframe share: calibration, as `EstimatorOptions::calibration_error`.
  double common_range_error = 0.002;
  /// The same for a camera with an IMU, whose scale has a sigma of about 1 % after initialization.
  double inertial_range_error = 0.01;
  /// Of a verified pose against one shifted to where the surroundings look alike, loop_aliases.hpp.
  double alias_odds = 1e3;
  double min_alias = 0.1;         ///< least shift that counts as another place, in ranges; below, the odometry is off
  double pose_inflation = 1;      ///< of the covariance of a verified pose
  double agreement_share = 1e-4;  ///< of true pairs of loops that do not agree
  int agreement_keyframes = 6;    ///< a second loop is to follow within so many keyframes
  int loop_spacing = 4;           ///< keyframes between two loops
  double max_tilt_rad = 0.05;     ///< of a correction, with an IMU; geometry: three sigmas of a tilt of 1 degree
  FrameLocalizerOptions frames;
  PointRecallOptions recall;
  double same_corner_px = 2;      ///< between a tracked point and one of the map that are the same
  double tracked_sigma_px = 0.5;  ///< of a tracked landmark, where its descriptor is found
  double corner_sigma_px = 1.0;   ///< of a corner, on its level
  int solver_budget = 4000;       ///< units a frame, pose_graph_solver.hpp
  NeighborhoodOptions neighborhood;
  int adjustment_budget = 4000;   ///< observations a frame, local_bundle_adjustment.hpp
  int enough_shared_points = 30;  ///< of two keyframes whose features are not compared again
  double min_overlap = 0.4;       ///< of the views of two keyframes that are compared for their poses
};

}  // namespace plumbline
