#include "plumbline/state/block.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"

using namespace plumbline;

namespace {

/// A block has an increment of the dimension that it states.
template <class Block, class S>
constexpr bool moves = requires(const typename Block::template Value<S>& x, const Vec<S, Block::dim>& d) {
  { plus(x, d) } -> std::convertible_to<typename Block::template Value<S>>;
};
template <class... Blocks>
constexpr bool all_move = (true && ... && (moves<Blocks, float> && moves<Blocks, double>));

static_assert(all_move<state::Pose, state::Velocity, state::GyroBias, state::AccelBias>);
static_assert(all_move<state::Extrinsics, state::TimeOffset>);

}  // namespace

TEST_CASE("block: dimensions are those of the increments") {
  REQUIRE(state::Pose::dim == 6);
  REQUIRE(state::Extrinsics::dim == 6);
  REQUIRE(state::Velocity::dim + state::GyroBias::dim + state::AccelBias::dim == 9);
  REQUIRE(state::TimeOffset::dim == 1);
}

TEST_CASE("block: blocks of one shape are distinguished by name") {
  STATIC_REQUIRE_FALSE(std::is_same_v<state::GyroBias, state::AccelBias>);
  STATIC_REQUIRE(std::is_same_v<state::GyroBias::Value<float>, state::AccelBias::Value<float>>);
  STATIC_REQUIRE(std::is_same_v<state::Pose::Value<double>, SE3<double>>);
}
