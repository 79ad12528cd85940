#pragma once
/// The types an estimator is composed of, chosen from its sensors, features and backend. The absence of a sensor is a
/// type, and is decided here.

#include <type_traits>

#include "plumbline/frontend/front_ends.hpp"
#include "plumbline/initialization/depth.hpp"
#include "plumbline/initialization/inertial.hpp"
#include "plumbline/initialization/two_view.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

namespace detail {
template <SensorRig Sensors, bool has_imu = Sensors::has_imu>
struct PropagationOf {
  using Type = ConstantVelocity<Sensors>;
};
template <SensorRig Sensors>
struct PropagationOf<Sensors, true> {
  using Type = Inertial<Sensors>;
};

template <SensorRig Sensors, bool has_depth = Sensors::has_depth, bool has_imu = Sensors::has_imu>
struct VisualInitializerOf {
  using Type = DepthInitializer<typename Sensors::Scalar>;
};
template <SensorRig Sensors>
struct VisualInitializerOf<Sensors, false, true> {
  using Type = TwoViewInitializer<typename Sensors::Scalar, GuidedTwoView>;
};
template <SensorRig Sensors>
struct VisualInitializerOf<Sensors, false, false> {
  using Type = TwoViewInitializer<typename Sensors::Scalar, UnguidedTwoView>;
};
}  // namespace detail

template <SensorRig SensorsT, class FeatureSet, class BackendPolicy>
struct Composition {
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;
  static constexpr int slots = BackendPolicy::slots;

  using Propagation = typename detail::PropagationOf<Sensors>::Type;
  using VisualInitializer = typename detail::VisualInitializerOf<Sensors>::Type;
  using Initializer =
      std::conditional_t<Sensors::has_imu, InertialInitializer<S, VisualInitializer>, VisualInitializer>;
  using FrontEnds = plumbline::FrontEnds<typename BackendPolicy::FrontEnds, Sensors, slots, FeatureSet>;
  using Landmarks = typename FrontEnds::Landmarks;
  using Backend = typename BackendPolicy::template Backend<Propagation, Landmarks>;
  using Window = typename Backend::Window;

  static_assert(
      Sensors::has_depth || FrontEnds::relates_two_views,
      "plumbline: without depth, initialization needs points, e.g. Features<InitializationPoints<200>, Lines<100>>");
};

}  // namespace plumbline
