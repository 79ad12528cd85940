#include "plumbline/state/frame_state.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

// What a camera alone does not have takes no memory.
static_assert(std::is_same_v<FrameValue<float, InertialLayout>, NavState<float>>);
static_assert(sizeof(PoseState<double>) == sizeof(SE3<double>));
static_assert(sizeof(FrameState<double, VisualLayout>) == sizeof(Estimated<state::Pose, double>));
static_assert(sizeof(FrameState<double, InertialLayout>) >
              sizeof(FrameState<double, VisualLayout>) + 3 * sizeof(Estimated<state::Velocity, double>) - 64);

namespace {

template <class S>
NavState<S> some_state() {
  NavState<S> x;
  x.T_world_body = SE3<S>(SO3<S>::exp({S(0.3), S(-0.2), S(0.5)}), Vec<S, 3>(1, 2, 3));
  x.v_world_body << S(0.5), S(-1), S(0.2);
  x.bias_gyro << S(0.01), S(0.02), S(-0.01);
  x.bias_accel << S(0.1), S(-0.2), S(0.3);
  return x;
}
/// 0.01, 0.02, ...: every number is its own.
template <class S>
Vec<S, 15> some_step() {
  Vec<S, 15> d;
  for (int k = 0; k < 15; ++k) d[k] = S(0.01) * S(k + 1);
  return d;
}
template <class S>
constexpr S tolerance = std::is_same_v<S, float> ? S(2e-6) : S(1e-13);

}  // namespace

TEMPLATE_TEST_CASE("frame_state: an increment reaches each block where the layout has it", "", float, double) {
  using S = TestType;
  const NavState<S> x = some_state<S>();
  const Vec<S, 15> d = some_step<S>();
  FrameState<S, InertialLayout> frame(x);
  REQUIRE(frame.correction().isZero(0));
  frame.add(d);
  REQUIRE(minus(frame.value(), plus(x, d)).norm() < tolerance<S>);
  REQUIRE(minus(frame.first_estimate(), plus(x, d)).norm() < tolerance<S>);

  frame = FrameState<S, InertialLayout>(x);
  frame.fix_first_estimates();
  frame.add(d);
  frame.add(d);
  REQUIRE((frame.correction() - 2 * d).norm() < tolerance<S>);
  REQUIRE(minus(frame.value(), plus(x, Vec<S, 15>(2 * d))).norm() < 2 * tolerance<S>);
  REQUIRE(minus(frame.first_estimate(), x).norm() == 0);
  REQUIRE(frame.template get<state::Velocity>().value() == frame.value().v_world_body);
}

TEMPLATE_TEST_CASE("frame_state: values by name, and a layout of the pose alone", "", float, double) {
  using S = TestType;
  const NavState<S> x = some_state<S>();
  REQUIRE(&value_of<state::Pose>(x) == &x.T_world_body);
  REQUIRE(&value_of<state::Velocity>(x) == &x.v_world_body);
  REQUIRE(&value_of<state::GyroBias>(x) == &x.bias_gyro);
  REQUIRE(&value_of<state::AccelBias>(x) == &x.bias_accel);

  FrameState<S, VisualLayout> frame({x.T_world_body});
  const Vec<S, 6> d = segment<6>(some_step<S>(), 0);
  frame.add(d);
  REQUIRE(minus(frame.value().T_world_body, plus(x.T_world_body, d)).norm() < tolerance<S>);
}

TEST_CASE("frame_state: the default is stationary in the origin") {
  const FrameState<double, InertialLayout> frame;
  REQUIRE(minus(frame.value(), NavState<double>()).norm() == 0);
}
