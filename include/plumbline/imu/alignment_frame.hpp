#pragma once
/// One frame of what vision gives to align with the IMU: a camera pose, and the readings since the frame before.

#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// P is a Preintegration; the frames' owner keeps it. Poses are in any fixed frame, their translations metric or up to
/// scale.
template <class P>
struct AlignmentFrame {
  SE3<typename P::Scalar> T_ref_cam;
  P* imu = nullptr;  ///< from the previous frame to this one; not read for the first frame
};

}  // namespace plumbline
