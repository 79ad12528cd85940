#pragma once
/// Images whose rows are read one after the other.                                docs/math/rolling_shutter.md
///
/// The middle row is exposed at the frame's time stamp, row v of H  tau(v) readout  later, tau = (v + 1/2)/H - 1/2.
/// While the camera turns with angular rate w and moves with velocity v, what row v sees along bearing b, in a distance
/// of 1/lambda, is seen in the middle of the frame along
///   b_0 = Exp(w tau readout) b + lambda tau readout v,     d b_0/d readout = tau (w x b_0 + lambda v)        (1)

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

/// How a pixel or a bearing, brought to the middle of the frame, depends on the readout time and on how far away the
/// thing is that it shows.                                                                                  (1)
template <class S, int N>
struct RowSlope {
  Vec<S, N> by_turn = zeros<S, N>();   ///< d x/d readout while the camera turns
  Vec<S, N> by_shift = zeros<S, N>();  ///< and d2 x/(d readout d lambda) while it moves
  S inverse_range = S(0);              ///< lambda with which x was brought there [1/m]

  Vec<S, N> by_readout() const { return by_turn + inverse_range * by_shift; }
  /// It is found to be that far away; returns what is to be added to x.
  Vec<S, N> set_inverse_range(S lambda, S readout_s) {
    Vec<S, N> change = (readout_s * (lambda - inverse_range)) * by_shift;
    inverse_range = lambda;
    return change;
  }
  /// The camera is found to have moved otherwise; returns what is to be added to x.
  Vec<S, N> set_motion(const RowSlope& moved, S readout_s) {
    Vec<S, N> change = readout_s * (moved.by_readout() - by_readout());
    *this = moved;
    return change;
  }
  /// All lengths become `scale` times what they were.
  void rescale(S scale) {
    by_shift = scale * by_shift;
    inverse_range /= scale;
  }
};

/// A pixel as the middle of the frame would have seen it.
template <class S>
struct StillPixel {
  Vec<S, 2> uv;  ///< [px]
  RowSlope<S, 2> slope;
};

/// All rows at once: every pixel is that of the middle of the frame.
template <CameraModel Camera>
class GlobalShutter {
 public:
  using S = typename Camera::Scalar;

  GlobalShutter(const Camera&, int /*height*/, S /*readout_s*/, bool /*is_known*/ = false) {}
  void set_motion(const Vec<S, 3>&, const Vec<S, 3>&, S /*inverse_range*/) {}
  StillPixel<S> still(const Vec<S, 2>& uv, S /*inverse_range*/) const { return {uv, {}}; }
  RowSlope<S, 3> bearing_slope(const Vec<S, 2>&, const Vec<S, 3>&, S /*inverse_range*/) const { return {}; }
  Vec<S, 2> seen(const Vec<S, 2>& uv, S /*inverse_range*/) const { return uv; }
};

template <CameraModel Camera>
class RollingShutter {
 public:
  using S = typename Camera::Scalar;

  /// The camera does not move until its motion is set.
  RollingShutter(const Camera& camera, int height, S readout_s, bool is_known = false)
      : camera_(camera), height_(S(height)), readout_s_(readout_s), is_global_(is_known && readout_s == S(0)) {}

  /// The camera's, in its own coordinates [rad/s, m/s]; `inverse_range` of what it sees where nothing better is known.
  void set_motion(const Vec<S, 3>& angular_rate, const Vec<S, 3>& velocity, S inverse_range) {
    angular_rate_ = angular_rate;
    velocity_ = velocity;
    inverse_range_ = inverse_range;
  }

  /// Where the middle of the frame would have seen what was seen at `uv`, that far away; zero where that is not known.
  StillPixel<S> still(const Vec<S, 2>& uv, S inverse_range) const {
    const S lambda = known(inverse_range);
    StillPixel<S> out{uv, {zeros<S, 2>(), zeros<S, 2>(), lambda}};
    if (is_global_) return out;
    const Unprojection<S> ray = camera_.unproject(uv);
    if (!ray.valid) return out;
    const S tau = row_time(uv), t = tau * readout_s_;
    const Vec<S, 3> turned = SO3<S>::exp(angular_rate_ * t) * ray.bearing;
    const Projection<S> projection = camera_.project(Vec<S, 3>(turned + (lambda * t) * velocity_));  // (1)
    if (!projection.valid) return out;
    out.uv = projection.uv;
    out.slope.by_turn = projection.J_uv_p * Vec<S, 3>(tau * angular_rate_.cross(turned));
    out.slope.by_shift = projection.J_uv_p * Vec<S, 3>(tau * velocity_);
    return out;
  }

  /// Of the unit bearing b_0 that was seen at `uv` [1/s].
  RowSlope<S, 3> bearing_slope(const Vec<S, 2>& uv, const Vec<S, 3>& bearing, S inverse_range) const {
    const S tau = row_time(uv);
    const Vec<S, 3> across = velocity_ - dot(velocity_, bearing) * bearing;
    return {tau * angular_rate_.cross(bearing), tau * across, known(inverse_range)};
  }

  /// Where the image shows what the middle of the frame sees at `uv`, that far away; the inverse of `still`.
  Vec<S, 2> seen(const Vec<S, 2>& uv, S inverse_range) const {
    if (readout_s_ == S(0)) return uv;
    const Unprojection<S> ray = camera_.unproject(uv);
    if (!ray.valid) return uv;
    const Vec<S, 3> shift = known(inverse_range) * velocity_;
    Vec<S, 2> out = uv;
    for (int i = 0; i < 3; ++i) {  // the row that sees it decides when
      const S t = row_time(out) * readout_s_;
      const Projection<S> projection =
          camera_.project(SO3<S>::exp(angular_rate_ * -t) * Vec<S, 3>(ray.bearing - t * shift));
      if (!projection.valid) return uv;
      out = projection.uv;
    }
    return out;
  }

 private:
  S known(S inverse_range) const { return inverse_range > S(0) ? inverse_range : inverse_range_; }
  /// tau, in [-1/2, 1/2].
  S row_time(const Vec<S, 2>& uv) const { return (uv.y() + S(0.5)) / height_ - S(0.5); }

  const Camera& camera_;
  S height_;
  S readout_s_;
  bool is_global_;  ///< known to read all rows at once: nothing depends on the readout time
  Vec<S, 3> angular_rate_ = zeros<S, 3>(), velocity_ = zeros<S, 3>();
  S inverse_range_ = S(0);
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
