#pragma once
/// Rolling shutter: images whose rows are read one after the other.               docs/math/rolling_shutter.md
///
/// The middle row is exposed at the time stamp of the frame, row v of H later by  tau(v) readout,  tau = (v + 1/2)/H -
/// 1/2. While the camera rotates with angular rate w and moves with velocity v (in its own axes), a point observed by
/// row v along the bearing b at the distance 1/lambda has in the camera at the middle of the frame the direction
///   b_0 = Exp(w tau readout) b + lambda tau readout v,     d b_0/d readout = tau (w x b_0 + lambda v)        (1)

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/lie/so3.hpp"

namespace plumbline {

/// Readout time: time between the first and the last row of an image, with its sigma.
template <class S>
struct Readout {
  S value_s = S(0);  ///< readout time [s]; 0: global shutter
  S sigma_s = S(0);  ///< its sigma [s]; 0: known, else it is estimated
  /// The value is kept until the estimate differs significantly, as for a camera assumed to be global.
  bool is_held = false;
  bool is_known() const { return !(sigma_s > S(0)); }
};

/// Derivatives of a pixel or bearing x, corrected to the middle of the frame, by the readout time and the inverse range
/// of its point.                                                                                                    (1)
template <class S, int N>
struct RowDerivative {
  Vec<S, N> by_rotation = zeros<S, N>();     ///< d x/d readout by the rotation of the camera
  Vec<S, N> by_translation = zeros<S, N>();  ///< d2 x/(d readout d lambda) by its translation
  S inverse_range = S(0);                    ///< lambda with which x was corrected [1/m]

  /// d x/d readout.
  Vec<S, N> by_readout() const { return by_rotation + inverse_range * by_translation; }
  /// Sets another inverse range [1/m]; returns the change of x.
  Vec<S, N> set_inverse_range(S lambda, S readout_s) {
    Vec<S, N> change = (readout_s * (lambda - inverse_range)) * by_translation;
    inverse_range = lambda;
    return change;
  }
  /// Replaces the derivatives by those of another motion of the camera; returns the change of x.
  Vec<S, N> set_motion(const RowDerivative& moved, S readout_s) {
    Vec<S, N> change = readout_s * (moved.by_readout() - by_readout());
    *this = moved;
    return change;
  }
  /// Multiplies all lengths by `scale`.
  void rescale(S scale) {
    by_translation = scale * by_translation;
    inverse_range /= scale;
  }
};

/// A pixel corrected to the middle of the frame, with its derivatives.
template <class S>
struct StillPixel {
  Vec<S, 2> uv;  ///< [px]
  RowDerivative<S, 2> derivative;
};

/// Global shutter: all rows at once, no correction.
template <CameraModel Camera>
class GlobalShutter {
 public:
  using S = typename Camera::Scalar;

  GlobalShutter(const Camera&, int /*height*/, S /*readout_s*/, bool /*is_known*/ = false) {}
  void set_motion(const Vec<S, 3>&, const Vec<S, 3>&, S /*inverse_range*/) {}
  StillPixel<S> still(const Vec<S, 2>& uv, S /*inverse_range*/) const { return {uv, {}}; }
  RowDerivative<S, 3> bearing_derivative(const Vec<S, 2>&, const Vec<S, 3>&, S /*inverse_range*/) const { return {}; }
  Vec<S, 2> seen(const Vec<S, 2>& uv, S /*inverse_range*/) const { return uv; }
};

/// Correction of pixels by (1) for one frame.
template <CameraModel Camera>
class RollingShutter {
 public:
  using S = typename Camera::Scalar;

  /// The motion of the camera is zero until it is set.
  RollingShutter(const Camera& camera, int height, S readout_s, bool is_known = false)
      : camera_(&camera), height_(S(height)), readout_s_(readout_s), is_global_(is_known && readout_s == S(0)) {}

  /// Sets angular rate and velocity of the camera in its own axes [rad/s, m/s], and the `inverse_range` of points
  /// without one [1/m].
  void set_motion(const Vec<S, 3>& angular_rate, const Vec<S, 3>& velocity, S inverse_range) {
    angular_rate_ = angular_rate;
    velocity_ = velocity;
    inverse_range_ = inverse_range;
  }

  /// Corrects the pixel `uv` to the middle of the frame. `inverse_range` of its point [1/m]; 0: not known.
  StillPixel<S> still(const Vec<S, 2>& uv, S inverse_range) const {
    const S lambda = known(inverse_range);
    StillPixel<S> out{uv, {zeros<S, 2>(), zeros<S, 2>(), lambda}};
    if (is_global_) return out;
    const Unprojection<S> ray = camera_->unproject(uv);
    if (!ray.valid) return out;
    const S tau = row_time(uv), t = tau * readout_s_;
    const Vec<S, 3> turned = SO3<S>::exp(angular_rate_ * t) * ray.bearing;
    const Projection<S> projection = camera_->project(Vec<S, 3>(turned + (lambda * t) * velocity_));  // (1)
    if (!projection.valid) return out;
    out.uv = projection.uv;
    out.derivative.by_rotation = projection.J_uv_p * Vec<S, 3>(tau * angular_rate_.cross(turned));
    out.derivative.by_translation = projection.J_uv_p * Vec<S, 3>(tau * velocity_);
    return out;
  }

  /// Derivatives of the unit bearing b_0 observed at `uv` [1/s].
  RowDerivative<S, 3> bearing_derivative(const Vec<S, 2>& uv, const Vec<S, 3>& bearing, S inverse_range) const {
    const S tau = row_time(uv);
    const Vec<S, 3> across = velocity_ - dot(velocity_, bearing) * bearing;
    return {tau * angular_rate_.cross(bearing), tau * across, known(inverse_range)};
  }

  /// Pixel in the image of a point with the pixel `uv` at the middle of the frame; the inverse of `still`.
  Vec<S, 2> seen(const Vec<S, 2>& uv, S inverse_range) const {
    if (readout_s_ == S(0)) return uv;
    const Unprojection<S> ray = camera_->unproject(uv);
    if (!ray.valid) return uv;
    const Vec<S, 3> shift = known(inverse_range) * velocity_;
    Vec<S, 2> out = uv;
    for (int i = 0; i < 3; ++i) {  // the row determines the time: fixed-point iteration
      const S t = row_time(out) * readout_s_;
      const Projection<S> projection =
          camera_->project(SO3<S>::exp(angular_rate_ * -t) * Vec<S, 3>(ray.bearing - t * shift));
      if (!projection.valid) return uv;
      out = projection.uv;
    }
    return out;
  }

 private:
  S known(S inverse_range) const { return inverse_range > S(0) ? inverse_range : inverse_range_; }
  /// tau, in [-1/2, 1/2].
  S row_time(const Vec<S, 2>& uv) const { return (uv.y() + S(0.5)) / height_ - S(0.5); }

  const Camera* camera_;  ///< outlives it
  S height_;
  S readout_s_;
  bool is_global_;  ///< known to be global: nothing depends on the readout time
  Vec<S, 3> angular_rate_ = zeros<S, 3>(), velocity_ = zeros<S, 3>();
  S inverse_range_ = S(0);
};

/// Shutter policies of a vision sensor. With a global one neither rig nor landmarks store anything for the readout
/// time.
struct Global {
  static constexpr bool rolls = false;
  template <CameraModel Camera>
  using Model = GlobalShutter<Camera>;
};
struct Rolling {
  static constexpr bool rolls = true;
  template <CameraModel Camera>
  using Model = RollingShutter<Camera>;
};

}  // namespace plumbline
