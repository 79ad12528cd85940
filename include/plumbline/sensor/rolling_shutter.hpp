#pragma once
/// Images whose rows are read one after the other.                                docs/math/rolling_shutter.md
///
/// The middle row is exposed at the frame's time stamp, row v of H  tau(v) readout  later, tau = (v + 1/2)/H - 1/2.
/// While the camera turns with angular rate w, what row v sees along bearing b is seen in the middle of the frame along
///   b_0 = Exp(w tau readout) b,     d b_0/d readout = tau w x b_0                                            (1)
/// The translation during one readout is neglected.

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

/// Time between the first and the last row of an image, as far as it is known.
template <class S>
struct Readout {
  S value_s = S(0);  ///< 0: a global shutter
  S sigma_s = S(0);  ///< 0: known; else the estimator finds it out
};

template <CameraModel Camera>
class RollingShutter {
 public:
  using S = typename Camera::Scalar;

  /// A pixel as the middle of the frame would have seen it.
  struct Still {
    Vec<S, 2> uv;        ///< [px]
    Vec<S, 2> uv_slope;  ///< d uv / d readout [px/s]
  };

  /// The angular rate [rad/s] is the camera's, in its own coordinates.
  RollingShutter(const Camera& camera, int height, S readout_s, const Vec<S, 3>& angular_rate)
      : camera_(camera), height_(S(height)), readout_s_(readout_s), angular_rate_(angular_rate) {}

  void set_angular_rate(const Vec<S, 3>& angular_rate) { angular_rate_ = angular_rate; }

  /// Where the middle of the frame would have seen what was seen at `uv`.
  Still still(const Vec<S, 2>& uv) const {
    Still out{uv, Vec<S, 2>::Zero()};
    const Unprojection<S> ray = camera_.unproject(uv);
    if (!ray.valid) return out;
    const S tau = row_time(uv);
    const Vec<S, 3> bearing = SO3<S>::exp(angular_rate_ * (tau * readout_s_)) * ray.bearing;
    const Projection<S> projection = camera_.project(bearing);
    if (!projection.valid) return out;
    out.uv = projection.uv;
    out.uv_slope.noalias() = projection.J_uv_p * angular_rate_.cross(bearing) * tau;  // (1)
    return out;
  }

  /// d b_0 / d readout [1/s] of the bearing b_0 that was seen at `uv`.
  Vec<S, 3> bearing_slope(const Vec<S, 2>& uv, const Vec<S, 3>& bearing) const {
    return row_time(uv) * angular_rate_.cross(bearing);
  }

  /// Where the image shows what the middle of the frame sees at `uv`; the inverse of `still`.
  Vec<S, 2> seen(const Vec<S, 2>& uv) const {
    const Unprojection<S> ray = camera_.unproject(uv);
    if (!ray.valid) return uv;
    Vec<S, 2> out = uv;
    for (int i = 0; i < 3; ++i) {  // the row that sees it decides when
      const Projection<S> projection =
          camera_.project(SO3<S>::exp(angular_rate_ * (-row_time(out) * readout_s_)) * ray.bearing);
      if (!projection.valid) return uv;
      out = projection.uv;
    }
    return out;
  }

 private:
  /// tau, in [-1/2, 1/2].
  S row_time(const Vec<S, 2>& uv) const { return (uv.y() + S(0.5)) / height_ - S(0.5); }

  const Camera& camera_;
  S height_;
  S readout_s_;
  Vec<S, 3> angular_rate_;
};

}  // namespace plumbline
