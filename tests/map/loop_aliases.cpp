#include "plumbline/map/loop_aliases.hpp"

#include "catch.hpp"
#include "map/simulated_graph.hpp"

using namespace plumbline;
using test::SimulatedGraph;

TEMPLATE_TEST_CASE("loop_aliases: a loop counts where the odometry tells it from places that look alike", "",
                   RelativePoseResidual<double>, RelativePoseYawResidual<double>, RelativeSim3Residual<double>,
                   RelativePoseResidual<float>, RelativePoseYawResidual<float>, RelativeSim3Residual<float>) {
  using S = typename TestType::Scalar;
  constexpr int runs = 50, i = 2, j = 27;
  int certain = 0, confused = 0, seen = 0;
  for (int run = 0; run < runs; ++run) {
    SimulatedGraph<TestType> world(2000 + run, 30, {});
    const auto Q = world.covariance(world.sigma_loop);
    const auto loop = world.measure(i, j, world.sigma_loop, 1);
    const auto precise = predict_loop(*world.graph, i, j, loop, Q);
    const auto vague = predict_loop(*world.graph, i, j, loop, Q, {.covariance_inflation = 1e6});
    REQUIRE((precise.valid && vague.valid));
    LoopAliases<S> aliases;
    REQUIRE(!aliases.confuse(vague, loop, 1e3));  // nothing known
    aliases.add({S(3), S(0), S(0)});
    certain += !aliases.confuse(precise, loop, 1e3);
    confused += aliases.confuse(vague, loop, 1e3);
    // The same loop one alias away, as it is measured where the camera sees the next door.
    const auto at_alias = LoopAliases<S>::shifted(precise.T_i, loop, Vec<S, 3>(S(-3), S(0), S(0)));
    seen += aliases.confuse(predict_loop(*world.graph, i, j, at_alias, Q), at_alias, 1e3);
  }
  CHECK(certain > 0.95 * runs);
  CHECK(confused == runs);
  CHECK(seen == runs);
}

TEST_CASE("loop_aliases: each displacement once, the oldest one leaves, no NaN") {
  LoopAliases<double> aliases;
  aliases.add({1, 0, 0});
  aliases.add({-1.05, 0, 0});
  aliases.add({NAN, 0, 0});
  CHECK(aliases.size() == 1);
  for (int k = 2; k < 100; ++k) aliases.add({0, double(k) * double(k), 0});
  CHECK(aliases.size() == LoopAliases<double>::capacity);
  aliases.clear();
  CHECK(aliases.size() == 0);
}
