// From rows with a known readout error.
#include "plumbline/state/readout_filter.hpp"

#include <cmath>

#include "catch.hpp"

#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

/// What a frame says: pose and readout by rows with noise of one sigma; `rate` scales what the readout moves.
template <class S>
DenseNormalEquations<S, 7> frame(testing::Gaussian& random, S readout_error, S rate, S sigma) {
  DenseNormalEquations<S, 7> system;
  for (int i = 0; i < 60; ++i) {
    Mat<S, 1, 7> J;
    for (int k = 0; k < 6; ++k) J(k) = S(random());
    J(6) = rate * S(random());
    // Linearized at readout + error: r = J (0, error) + noise.
    system.add(Mat<S, 1, 7>(J / sigma), Vec<S, 1>((J(6) * readout_error + sigma * S(random())) / sigma), S(1));
  }
  return system;
}

}  // namespace

TEMPLATE_TEST_CASE("readout_filter: goes to the readout that explains the frames", "", float, double) {
  using S = TestType;
  testing::Gaussian random(1);
  ReadoutFilter<S> filter({S(0), S(0.02)}, {});
  const S truth = S(0.024);
  for (int i = 0; i < 200; ++i)
    filter.update(frame<S>(random, filter.readout().value_s - truth, S(500), S(0.7)), S(0.033));
  CAPTURE(filter.readout().value_s, filter.readout().sigma_s);
  REQUIRE(std::abs(filter.readout().value_s - truth) < S(1e-3));
  REQUIRE(filter.readout().sigma_s < S(2e-3));
}

TEMPLATE_TEST_CASE("readout_filter: stays where nothing turns, and within its limits", "", float, double) {
  using S = TestType;
  testing::Gaussian random(2);
  ReadoutFilter<S> filter({S(0.01), S(0.005)}, {});
  for (int i = 0; i < 100; ++i) filter.update(frame<S>(random, S(0.3), S(1e-3), S(0.7)), S(0.033));
  REQUIRE(std::abs(filter.readout().value_s - S(0.01)) < S(2e-3));
  for (int i = 0; i < 100; ++i) filter.update(frame<S>(random, S(0.3), S(500), S(0.7)), S(0.033));
  REQUIRE(filter.readout().value_s == S(0));
  for (int i = 0; i < 100; ++i) filter.update(frame<S>(random, S(-0.3), S(500), S(0.7)), S(0.033));
  REQUIRE(filter.readout().value_s == S(0.05));
  const DenseNormalEquations<S, 7> nothing;
  filter.update(nothing, S(0.033));
  REQUIRE(filter.readout().value_s == S(0.05));
}

TEMPLATE_TEST_CASE("readout_filter: a value that is held gives way to what is beyond doubt, not to noise", "", float,
                   double) {
  using S = TestType;
  for (const double truth : {0.0, 0.003, 0.02}) {
    testing::Gaussian random(3);
    ReadoutFilter<S> filter({S(0), S(0.02), true}, {});
    int held = 0;
    for (int i = 0; i < 200; ++i) {
      filter.update(frame<S>(random, filter.readout().value_s - S(truth), S(500), S(0.7)), S(0.033));
      held += filter.readout().is_held;
    }
    CAPTURE(truth, held, filter.readout().value_s);
    if (truth < 0.01) {
      REQUIRE(held == 200);
      REQUIRE(filter.readout().value_s == S(0));
    } else {
      REQUIRE(held < 20);
      REQUIRE(std::abs(filter.readout().value_s - S(truth)) < S(1e-3));
    }
  }
}
