// What an estimator is composed of follows from the types that name it, and from nothing else.
#include "plumbline/estimator/composition.hpp"

#include <concepts>

#include "catch.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/collinear.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/initialization_points.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

using Camera = Pinhole<float>;
using MonoRig = Rig<Mono<Camera>>;
using MonoImuRig = Rig<Mono<Camera>, Imu>;
using RgbdRig = Rig<Rgbd<Camera>>;
using RgbdImuRig = Rig<Rgbd<Camera>, Imu>;

template <class Sensors, class FeatureSet = Features<Points<50>>>
using Of = Composition<Sensors, FeatureSet, SlidingWindow<4>>;

}  // namespace

TEST_CASE("composition: the IMU decides on the propagation, and with it on a frame's state and on factors") {
  STATIC_REQUIRE(std::same_as<Of<MonoRig>::Propagation, ConstantVelocity<MonoRig>>);
  STATIC_REQUIRE(std::same_as<Of<RgbdRig>::Propagation, ConstantVelocity<RgbdRig>>);
  STATIC_REQUIRE(std::same_as<Of<MonoImuRig>::Propagation, Inertial<MonoImuRig>>);
  STATIC_REQUIRE(std::same_as<Of<RgbdImuRig>::Propagation, Inertial<RgbdImuRig>>);
  STATIC_REQUIRE(std::same_as<Of<MonoRig>::Window, FrameWindow<float, VisualLayout, 4>>);
  STATIC_REQUIRE(std::same_as<Of<MonoImuRig>::Window, FrameWindow<float, InertialLayout, 4>>);
  STATIC_REQUIRE(std::same_as<Of<RgbdRig>::Backend::Factors, NoFactors>);
  STATIC_REQUIRE(std::same_as<Of<RgbdImuRig>::Backend::Factors, ImuFactors<float, 4>>);
}

TEST_CASE("composition: depth decides on the start, an IMU comes on top of it") {
  STATIC_REQUIRE(std::same_as<Of<RgbdRig>::Initializer, DepthInitializer<float>>);
  STATIC_REQUIRE(std::same_as<Of<MonoRig>::Initializer, TwoViewInitializer<float, UnguidedTwoView>>);
  STATIC_REQUIRE(std::same_as<Of<RgbdImuRig>::Initializer, InertialInitializer<float, DepthInitializer<float>>>);
  STATIC_REQUIRE(
      std::same_as<Of<MonoImuRig>::Initializer, InertialInitializer<float, TwoViewInitializer<float, GuidedTwoView>>>);
}

TEST_CASE("composition: each kind has a store of its own and the front end that the policy names") {
  using Both = Of<RgbdRig, Features<Points<50>, Lines<20>>>;
  using PointStore = LandmarkStore<PointKind<RgbdRig>, 50, 4>;
  using LineStore = LandmarkStore<LineKind<RgbdRig>, 20, 4>;
  STATIC_REQUIRE(std::same_as<Both::Landmarks, LandmarkSet<PointStore, LineStore>>);
  STATIC_REQUIRE(std::same_as<Both::FrontEnds::Of<Points<50>>, PointFlow<PointStore>>);
  STATIC_REQUIRE(std::same_as<Both::FrontEnds::Of<Lines<20>>, EdgeFollowing<LineStore>>);
  using Begun = Of<MonoImuRig, Features<InitializationPoints<60>, Lines<20>>>;
  using StartStore = LandmarkStore<PointKind<MonoImuRig>, 60, 4>;
  STATIC_REQUIRE(std::same_as<Begun::FrontEnds::Of<InitializationPoints<60>>, InitializationFlow<StartStore>>);
}

TEST_CASE("composition: collinear features hold the points named before them, with and without lines") {
  using PointStore = LandmarkStore<PointKind<MonoRig>, 50, 4>;
  using CollinearStore = LandmarkStore<CollinearKind<MonoRig>, 20, 4>;
  using Both = Of<MonoRig, Features<Points<50>, Collinear<20>>>;
  using All = Of<MonoRig, Features<Points<50>, Lines<20>, Collinear<20>>>;
  STATIC_REQUIRE(std::same_as<Both::Landmarks, LandmarkSet<PointStore, CollinearStore>>);
  STATIC_REQUIRE(std::same_as<Both::FrontEnds::Of<Collinear<20>>, CollinearSegments<CollinearStore>>);
  STATIC_REQUIRE(std::same_as<All::FrontEnds::Of<Collinear<20>>, CollinearSegments<CollinearStore>>);
  STATIC_REQUIRE(LandmarkTies<Both::Landmarks>::any);
  STATIC_REQUIRE(LandmarkTies<All::Landmarks>::any);
  STATIC_REQUIRE_FALSE(LandmarkTies<Of<MonoRig>::Landmarks>::any);
  STATIC_REQUIRE_FALSE(LandmarkTies<Of<MonoRig, Features<Points<50>, Lines<20>>>::Landmarks>::any);
}

TEST_CASE("composition: the robust kernel is a part of a kind") {
  using Robust = Of<RgbdRig, Features<Points<50, Cauchy>, Lines<20, LineSegmentDetector<>, Tukey>>>;
  using PointStore = LandmarkStore<PointKind<RgbdRig, Cauchy>, 50, 4>;
  using LineStore = LandmarkStore<LineKind<RgbdRig, Tukey>, 20, 4>;
  STATIC_REQUIRE(std::same_as<Robust::Landmarks, LandmarkSet<PointStore, LineStore>>);
  STATIC_REQUIRE(std::same_as<Robust::FrontEnds::Of<Points<50, Cauchy>>, PointFlow<PointStore>>);
  STATIC_REQUIRE(std::same_as<Features<Points<50>>, Features<Points<50, Huber>>>);
}

TEST_CASE("composition: a camera without depth starts by what relates two views") {
  STATIC_REQUIRE(Of<MonoRig>::FrontEnds::relates_two_views);
  STATIC_REQUIRE(Of<MonoRig, Features<InitializationPoints<60>, Lines<20>>>::FrontEnds::relates_two_views);
  STATIC_REQUIRE(!Of<RgbdRig, Features<Lines<20>>>::FrontEnds::relates_two_views);
}
