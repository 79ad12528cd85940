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
  S value_s = S(0);      ///< 0: all rows at once
  S sigma_s = S(0);      ///< 0: known; else the estimator finds it out
  bool is_held = false;  ///< until images contradict the value beyond doubt: most cameras of robots do not roll
  bool is_known() const { return !(sigma_s > S(0)); }
};

/// A pixel as the middle of the frame would have seen it.
template <class S>
struct StillPixel {
  Vec<S, 2> uv;        ///< [px]
  Vec<S, 2> uv_slope;  ///< d uv / d readout [px/s]
};

/// All rows at once: every pixel is that of the middle of the frame.
template <CameraModel Camera>
class GlobalShutter {
 public:
  using S = typename Camera::Scalar;

  GlobalShutter(const Camera&, int /*height*/, S /*readout_s*/, bool /*is_known*/ = false) {}
  void set_angular_rate(const Vec<S, 3>&) {}
  StillPixel<S> still(const Vec<S, 2>& uv) const { return {uv, zeros<S, 2>()}; }
  Vec<S, 3> bearing_slope(const Vec<S, 2>&, const Vec<S, 3>&) const { return zeros<S, 3>(); }
  Vec<S, 2> seen(const Vec<S, 2>& uv) const { return uv; }
};

template <CameraModel Camera>
class RollingShutter {
 public:
  using S = typename Camera::Scalar;

  /// The camera does not turn until its angular rate is set.
  RollingShutter(const Camera& camera, int height, S readout_s, bool is_known = false)
      : camera_(camera), height_(S(height)), readout_s_(readout_s), is_global_(is_known && readout_s == S(0)) {}

  /// [rad/s], the camera's, in its own coordinates.
  void set_angular_rate(const Vec<S, 3>& angular_rate) { angular_rate_ = angular_rate; }

  /// Where the middle of the frame would have seen what was seen at `uv`.
  StillPixel<S> still(const Vec<S, 2>& uv) const {
    StillPixel<S> out{uv, zeros<S, 2>()};
    if (is_global_) return out;
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
    if (readout_s_ == S(0)) return uv;
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
  bool is_global_;  ///< known to read all rows at once: nothing depends on the readout time
  Vec<S, 3> angular_rate_ = zeros<S, 3>();
};

/// Shutter policies of a vision sensor. A global shutter has no readout time, and landmarks nothing that depends on it.
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
