#pragma once
/// Corners of a recording's images, followed from frame to frame.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/io/recording.hpp"

struct TrackedCorner {
  std::uint32_t id;
  plumbline::Vec<double, 2> uv;       ///< [px]
  plumbline::Vec<double, 3> bearing;  ///< in the camera
  double depth_m;                     ///< along the optical axis; 0: not measured
};

struct TrackedFrame {
  plumbline::TimeNs t_ns;
  bool follows;  ///< the frame before it in the recording is the one before it here
  std::vector<TrackedCorner> corners;
  double brightness = 0, contrast = 0;  ///< mean and standard deviation of the pixels, 0 to 255
};

/// Whether corners are followed in images of that size: 256 px on each side, up to 9 million pixels.
bool can_track(const plumbline::io::CameraCalibration& camera);

/// Of at most `most` frames: blocks of consecutive ones, spread over the recording. Images that cannot be read are left
/// out. Depth is read four times a second.
std::vector<TrackedFrame> track_corners(const plumbline::io::Recording& recording, std::size_t most = 1000);

/// The same corner in two frames.
struct CornerPair {
  const TrackedCorner *first, *second;
};
std::vector<CornerPair> pairs_of(const TrackedFrame& first, const TrackedFrame& second);
