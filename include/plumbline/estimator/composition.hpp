#pragma once
/// The types an estimator is composed of, chosen from its sensors, features and backend. The absence of a sensor is a
/// type, and is decided here.

#include <cstddef>
#include <type_traits>

#include "plumbline/backend/backend.hpp"
#include "plumbline/frontend/front_ends.hpp"
#include "plumbline/initialization/depth.hpp"
#include "plumbline/initialization/inertial.hpp"
#include "plumbline/initialization/initializer.hpp"
#include "plumbline/initialization/two_view.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline {

/// The propagation of a rig. To be specialized for a rig with another one.
template <SensorRig Sensors>
struct PropagationOf {
  using Type = std::conditional_t<Sensors::has_imu, Inertial<Sensors>, ConstantVelocity<Sensors>>;
};

/// The initializer of a rig. To be specialized for a rig with another one.
template <SensorRig Sensors>
struct InitializerOf {
  using S = typename Sensors::Scalar;
  template <template <class, std::size_t> class Solver>
  using TwoViews = std::conditional_t<Sensors::has_depth, DepthInitializer<S>, TwoViewInitializer<S, Solver>>;
  using Type =
      std::conditional_t<Sensors::has_imu, InertialInitializer<S, TwoViews<GuidedTwoView>>, TwoViews<UnguidedTwoView>>;
};

template <SensorRig SensorsT, class FeatureSet, class BackendPolicy>
struct Composition {
  using Sensors = SensorsT;
  using S = typename Sensors::Scalar;
  static constexpr int slots = BackendPolicy::slots;

  using Propagation = typename PropagationOf<Sensors>::Type;
  using Initializer = typename InitializerOf<Sensors>::Type;
  using FrontEnds = plumbline::FrontEnds<typename BackendPolicy::FrontEnds, Sensors, slots, FeatureSet>;
  using Landmarks = typename FrontEnds::Landmarks;
  using Backend = typename BackendPolicy::template Backend<Propagation, Landmarks>;
  using Window = typename Backend::Window;

  static_assert(
      Sensors::has_depth || FrontEnds::relates_two_views,
      "plumbline: without depth, initialization needs points, e.g. Features<InitializationPoints<200>, Lines<100>>");
  static_assert(plumbline::Propagation<Propagation>, "plumbline: see the concept in propagation/propagation.hpp");
  static_assert(plumbline::Initializer<Initializer, Sensors>, "plumbline: see initialization/initializer.hpp");
  static_assert(FrontEnds::template are_front_ends<Window>, "plumbline: see the concept in frontend/front_end.hpp");
  static_assert(plumbline::Backend<Backend> && (Sensors::has_depth || HoldsScale<Backend>),
                "plumbline: a backend lacks a call, see backend/backend.hpp");
  static_assert(!Sensors::has_imu || (InertialBackend<Backend> && (Sensors::has_depth || HoldsDistance<Backend>)),
                "plumbline: with an IMU a backend has more calls, see backend/backend.hpp");
};

}  // namespace plumbline
