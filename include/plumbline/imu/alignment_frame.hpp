#pragma once
/// One frame of what vision gives to align with the IMU: a camera pose, and the readings since the frame before.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// P is a Preintegration; the frames' owner keeps it. Poses are in any fixed frame, their translations metric or up to
/// scale.
template <class P>
struct AlignmentFrame {
  using S = typename P::Scalar;

  SE3<S> T_ref_cam;
  P* imu = nullptr;  ///< from the previous frame to this one; not read for the first frame
  /// Of the pose's own noise, in axes of the body and units of the poses, beside what all of them have.
  Mat<S, 3, 3> position_covariance = zeros<Mat<S, 3, 3>>();
};

}  // namespace plumbline
