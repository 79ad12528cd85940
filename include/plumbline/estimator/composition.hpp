#pragma once
/// What an estimator is composed of, from its sensors, features and backend. Absence is decided here, once, and is a
/// type.

#include <type_traits>

#include "plumbline/frontend/front_ends.hpp"
#include "plumbline/motion/constant_velocity.hpp"
#include "plumbline/motion/inertial.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/start/depth.hpp"
#include "plumbline/start/inertial.hpp"
#include "plumbline/start/two_view.hpp"

namespace plumbline {

namespace detail {
template <SensorRig Sensors, bool has_imu = Sensors::has_imu>
struct MotionOf {
  using Type = ConstantVelocity<Sensors>;
};
template <SensorRig Sensors>
struct MotionOf<Sensors, true> {
  using Type = Inertial<Sensors>;
};

template <SensorRig Sensors, bool has_depth = Sensors::has_depth, bool has_imu = Sensors::has_imu>
struct VisualStartOf {
  using Type = DepthStart<typename Sensors::Scalar>;
};
template <SensorRig Sensors>
struct VisualStartOf<Sensors, false, true> {
  using Type = TwoViewStart<typename Sensors::Scalar, GuidedTwoView>;
};
template <SensorRig Sensors>
struct VisualStartOf<Sensors, false, false> {
  using Type = TwoViewStart<typename Sensors::Scalar, UnguidedTwoView>;
};
}  // namespace detail

template <SensorRig SensorsT, class FeatureSet, class BackendPolicy>
struct Composition {
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;
  static constexpr int slots = BackendPolicy::slots;

  using Motion = typename detail::MotionOf<Sensors>::Type;
  using VisualStart = typename detail::VisualStartOf<Sensors>::Type;
  using Start = std::conditional_t<Sensors::has_imu, InertialStart<S, VisualStart>, VisualStart>;
  using FrontEnds = plumbline::FrontEnds<typename BackendPolicy::FrontEnds, Sensors, slots, FeatureSet>;
  using Landmarks = typename FrontEnds::Landmarks;
  using Backend = typename BackendPolicy::template Backend<Motion, Landmarks>;
  using Window = typename Backend::Window;

  static_assert(Sensors::has_depth || FrontEnds::relates_two_views,
                "plumbline: a camera without depth starts by points, e.g. Features<StartPoints<200>, Lines<100>>");
};

}  // namespace plumbline
