#include "plumbline/propagation/pose_gates.hpp"

#include "catch.hpp"

using namespace plumbline;

namespace {
struct Gates {
  InertialOptions options;
  VelocityUncertainty<double> velocity{options.velocity_sigma};
  PoseGates<double> gates;
  Prediction<NavState<double>, double> predicted{{}, {true}};

  void predict(double outage_s) {
    ImuIncrement<double> increment(Vec<double, 3>::Zero(), Vec<double, 3>::Zero());
    gates.predict(increment, velocity, outage_s, options, predicted.prior);
  }
};
SE3<double> moved(double x) { return SE3<double>({}, {x, 0, 0}); }
}  // namespace

TEST_CASE("pose_gates: the sigmas of a pose, the position's in proportion to the outage") {
  Gates at;
  at.predict(0.5);
  CHECK(at.predicted.prior.sigma[0] == Approx(at.options.rotation_sigma));
  CHECK(at.predicted.prior.sigma[3] == Approx(0.5 * at.options.velocity_sigma));
}

TEST_CASE("pose_gates: the innovation gate is the unknown velocity's, the consensus gate the window's") {
  Gates at;
  const double sigma_m = 0.1 * at.options.velocity_sigma;
  at.predict(0.1);
  CHECK(at.gates.passes_consensus(at.predicted, moved(100 * sigma_m), 2));  // the window does not determine it
  VelocityUncertainty<double>::Covariance P = VelocityUncertainty<double>::Covariance::Zero();
  P(6, 6) = 0.01 * at.options.velocity_sigma * at.options.velocity_sigma;
  at.velocity.set_latest(P, 1);
  at.predict(0.1);
  CHECK(at.gates.passes_consensus(at.predicted, moved(0.19 * sigma_m), 2));
  CHECK_FALSE(at.gates.passes_consensus(at.predicted, moved(0.21 * sigma_m), 2));
  CHECK(at.gates.passes_innovation(at.predicted, moved(1.9 * sigma_m), 2));
  CHECK_FALSE(at.gates.passes_innovation(at.predicted, moved(2.1 * sigma_m), 2));
}
