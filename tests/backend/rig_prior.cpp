#include "plumbline/backend/rig_prior.hpp"

#include <type_traits>

#include "catch.hpp"
#include "plumbline/state/frame_window.hpp"

using namespace plumbline;

TEST_CASE("rig_prior: mount and clock are estimated, the clock unless it is known") {
  for (const bool known : {true, false}) {
    FrameWindow<double, InertialLayout, 3> window;
    RigPrior<InertialLayout> prior({}, {});
    CHECK(prior.cost(window) == 0);
    prior.begin(window, SE3<double>(), {0.02, 0, known});
    CHECK(window.estimates_extrinsics());
    CHECK(window.estimates_time_offset() == !known);
    CHECK(prior.cost(window) == 0);
    Vec<double, 3 * 15 + 7> step = Vec<double, 3 * 15 + 7>::Zero();
    step[3 * 15 + 6] = 1e-3;
    window.move(step);
    const double cost = TimeOffsetPrior(TimeOffsetOptions{}, 0).cost(1e-3);
    CHECK(prior.cost(window) == Approx(known ? 0 : cost));
  }
}

TEST_CASE("rig_prior: a clock without a sigma is known") {
  FrameWindow<double, InertialLayout, 3> window;
  TimeOffsetOptions exact;
  exact.sigma_s = 0;
  RigPrior<InertialLayout> prior({}, exact);
  prior.begin(window, SE3<double>(), {.known = false});
  CHECK_FALSE(window.estimates_time_offset());
}

TEST_CASE("rig_prior: of a camera alone there is nothing to know") {
  STATIC_REQUIRE(sizeof(FrameWindow<double, InertialLayout, 3>) > sizeof(FrameWindow<double, VisualLayout, 3>));
  struct With {
    int a;
    [[no_unique_address]] RigPrior<VisualLayout> prior;
  };
  STATIC_REQUIRE(sizeof(With) <= 2 * sizeof(int));
  STATIC_REQUIRE(std::is_empty_v<RigPrior<VisualLayout>>);
}
