#pragma once
/// One frame of the visual-inertial alignment: a camera pose, and the preintegration since the previous frame.

#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/se3.hpp"

namespace plumbline {

/// P is a Preintegration, owned by the caller. Poses are in any fixed frame `ref`, metric or up to scale.
template <class P>
struct AlignmentFrame {
  using S = typename P::Scalar;

  SE3<S> T_ref_cam;
  P* imu = nullptr;  ///< from the previous frame to this one; unused in the first frame
  /// Covariance of the position of this pose, in axes of the body and units of the poses, besides the `position_sigma`
  /// of all poses.
  Mat<S, 3, 3> position_covariance = zeros<Mat<S, 3, 3>>();
};

}  // namespace plumbline
