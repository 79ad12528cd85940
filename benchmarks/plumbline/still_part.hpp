#pragma once
/// Parts of the image that do not move while the camera turns: a bonnet, legs of the robot, dirt on the lens.

#include <vector>

#include "corner_tracks.hpp"
#include "plumbline/io/calibration_data.hpp"
#include "rotation_fit.hpp"

struct StillPart {
  double share = 0;                              ///< of the image
  int left = 0, top = 0, right = 0, bottom = 0;  ///< the box around it [px]
};

/// By the cells of a grid in which most corners stay where they are while the rotation of the images moves them by
/// pixels.
StillPart find_still_part(const std::vector<TrackedFrame>& frames, const std::vector<ImageRate>& rates,
                          const plumbline::io::CameraCalibration& calibration);
