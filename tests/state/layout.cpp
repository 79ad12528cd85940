#include "plumbline/state/layout.hpp"

#include "catch.hpp"
#include "plumbline/imu/nav_state.hpp"

using namespace plumbline;

namespace {

template <class L, class Block>
constexpr bool ends_where_next_begins(int next) {
  return L::template offset<Block> + Block::dim == next;
}

}  // namespace

TEST_CASE("layout: offsets are the dimensions before, in the order of the names") {
  using L = Layout<state::Velocity, state::Pose, state::TimeOffset, state::GyroBias>;
  STATIC_REQUIRE(L::offset<state::Velocity> == 0);
  STATIC_REQUIRE(ends_where_next_begins<L, state::Velocity>(L::offset<state::Pose>));
  STATIC_REQUIRE(ends_where_next_begins<L, state::Pose>(L::offset<state::TimeOffset>));
  STATIC_REQUIRE(ends_where_next_begins<L, state::TimeOffset>(L::offset<state::GyroBias>));
  STATIC_REQUIRE(ends_where_next_begins<L, state::GyroBias>(L::dim));
  STATIC_REQUIRE(L::has<state::TimeOffset>);
  STATIC_REQUIRE_FALSE(L::has<state::AccelBias>);
  STATIC_REQUIRE(Layout<>::dim == 0);
  STATIC_REQUIRE_FALSE(Layout<>::has<state::Pose>);
}

TEST_CASE("layout: a frame of a rig with an IMU has the order of NavState's error") {
  using X = NavState<double>;
  STATIC_REQUIRE(InertialLayout::dim == X::dof);
  STATIC_REQUIRE(InertialLayout::offset<state::Pose> == X::rotation);
  STATIC_REQUIRE(InertialLayout::offset<state::Velocity> == X::velocity);
  STATIC_REQUIRE(InertialLayout::offset<state::GyroBias> == X::gyro_bias);
  STATIC_REQUIRE(InertialLayout::offset<state::AccelBias> == X::accel_bias);
  STATIC_REQUIRE(VisualLayout::dim == state::Pose::dim);
}

TEST_CASE("layout: extrinsics and time offset are estimated with an IMU") {
  STATIC_REQUIRE(RigLayout<VisualLayout>::dim == 0);
  STATIC_REQUIRE_FALSE(has_extrinsics<VisualLayout>);
  STATIC_REQUIRE_FALSE(has_time_offset<VisualLayout>);
  STATIC_REQUIRE(has_extrinsics<InertialLayout>);
  STATIC_REQUIRE(has_time_offset<InertialLayout>);
}
