// What the policy SlidingWindow names: a window of that many frames, its front ends, and factors of frames.
#include "plumbline/backend/sliding_window.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/factor/absolute_position.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/frontend/direct_alignment.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

using namespace plumbline;

namespace {
using Sensors = Rig<Rgbd<Pinhole<float>>>;
using Landmarks = Features<Points<20>>::Landmarks<Sensors, 4>;
template <class Policy>
using BackendOf = typename Policy::template Backend<ConstantVelocity<Sensors>, Landmarks>;
using Plain = BackendOf<SlidingWindow<4>>;
using Positioned = BackendOf<SlidingWindow<4, Flow, AbsolutePosition>>;

template <class B>
concept TakesPosition = TakesFactor<B, AbsolutePosition<float>>;
}  // namespace

TEST_CASE("sliding_window: its frames, its front ends and its factors are those of the policy") {
  STATIC_REQUIRE(std::is_same_v<Plain, WindowBackend<ConstantVelocity<Sensors>, Landmarks, 4>>);
  STATIC_REQUIRE(Plain::Window::slots == SlidingWindow<4>::slots);
  STATIC_REQUIRE(std::is_same_v<SlidingWindow<4>::FrontEnds, Flow>);
  STATIC_REQUIRE(std::is_same_v<SlidingWindow<4, DirectAlignment>::FrontEnds, DirectAlignment>);
  STATIC_REQUIRE((TakesPosition<Positioned> && !TakesPosition<Plain>));
  STATIC_REQUIRE((Backend<Plain> && Backend<Positioned>));
}
