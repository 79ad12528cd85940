#pragma once
/// Options of the front end of points by optical flow, with their defaults for each rig.        docs/math/tracking.md

#include "plumbline/geometry/triangulation.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/corner_detector.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/optical_flow.hpp"
#include "plumbline/tracking/surface_slant.hpp"

namespace plumbline {

struct PointFlowOptions {
  /// Sigma of an aligned observation of a patch with strong texture [px]; tuned: docs/decisions/051.
  double sigma_px = 0.2;
  /// Intensity sigma of an aligned observation, in rms residuals of its patch; above 1 because they are correlated;
  /// tuned: docs/decisions/051.
  double sigma_residual = 4;
  /// Sigma of an observation by optical flow alone [px]; tuned: docs/decisions/135 (chosen).
  double sigma_flow_px = 1.0;
  /// Corners are added until this many landmarks are in view; tuned: docs/decisions/135 (chosen).
  int target_count = 180;
  /// Largest number of landmarks out of view that one frame searches; tuned: docs/decisions/135 (chosen).
  int max_searches = 200;
  /// Views besides the anchor that must agree to locate a point without depth; geometry: two views triangulate.
  int min_views = 1;
  /// Largest distance between the results of flow and alignment [px]; tuned: docs/decisions/135 (chosen).
  float max_drift_px = 2.0f;
  OpticalFlowOptions flow;
  AlignmentOptions alignment;
  SlantOptions slant;
  CornerOptions corners;
  TriangulationOptions triangulation;
};

/// Default options of a rig. With an IMU the sigmas of aligned points must be accurate, because the scale depends on
/// their weight against IMU factors; without one only their ratios matter. Points without measured depth on an RGB-D
/// rig may move with the camera, and a single view would locate them wrongly.
///                                                                          docs/math/point.md, docs/math/geometry.md 4
template <SensorRig Sensors>
struct PointOptionsOf : PointFlowOptions {
  constexpr PointOptionsOf() {
    if constexpr (Sensors::has_imu) {
      sigma_px = 0.1;                                   // tuned: docs/decisions/051
      sigma_residual = 3;                               // tuned: docs/decisions/051
      if constexpr (Sensors::has_depth) min_views = 3;  // tuned: docs/decisions/070
    }
  }
};

}  // namespace plumbline
