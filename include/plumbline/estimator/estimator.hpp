#pragma once
/// Visual and visual-inertial odometry from a rig, feature kinds and a backend, all named in the type:
///
///   using Vio = Estimator<Rig<Rgbd<Pinhole<float>>, Imu>, Features<Points<180>>, SlidingWindow<10>>;
///   static Vio vio{rig, options};                       // every byte it will ever use
///   vio.add_imu({t_ns, gyro, accel});                   // rigs with an IMU: rad/s, m/s^2
///   Result<Estimate<float>> estimate = vio.add_frame({t_ns, gray, depth});
///
/// One frame, front to back: predict, track, estimate, keyframe (detect, optimize, marginalize), publish.
/// Same input, same output, bit for bit.

#include <type_traits>

#include "plumbline/estimator/clock.hpp"
#include "plumbline/estimator/inertial_estimator.hpp"
#include "plumbline/estimator/visual_estimator.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

namespace detail {
template <bool has_imu>
struct EstimatorOf {
  template <class... Policies>
  using Type = VisualEstimator<Policies...>;
};
template <>
struct EstimatorOf<true> {
  template <class... Policies>
  using Type = InertialEstimator<Policies...>;
};
}  // namespace detail

template <class Sensors, class FeatureSet, class BackendPolicy, Clock TimeSource = NoClock>
class Estimator
    : public detail::EstimatorOf<Sensors::has_imu>::template Type<Sensors, FeatureSet, BackendPolicy, TimeSource> {
  static_assert(SensorRig<Sensors>, "plumbline: argument 1 must be a rig, e.g. Rig<Rgbd<Pinhole<float>>>");
  using Base =
      typename detail::EstimatorOf<Sensors::has_imu>::template Type<Sensors, FeatureSet, BackendPolicy, TimeSource>;

 public:
  using Base::Base;
};

}  // namespace plumbline
