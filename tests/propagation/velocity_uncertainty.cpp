#include "plumbline/propagation/velocity_uncertainty.hpp"

#include <cmath>

#include "catch.hpp"

using namespace plumbline;

namespace {
using Velocity = VelocityUncertainty<double>;
Velocity::Covariance covariance(double sigma_x, double sigma_yz) {
  Velocity::Covariance P = Velocity::Covariance::Zero();
  P(6, 6) = sigma_x * sigma_x;
  P(7, 7) = P(8, 8) = sigma_yz * sigma_yz;
  return P;
}
}  // namespace

TEST_CASE("velocity_uncertainty: that of the latest state is the largest axis, inflated, until it is unknown") {
  Velocity velocity(0.1);
  CHECK_FALSE(velocity.is_known());
  velocity.set_latest(covariance(0.01, 0.02), 3);
  CHECK(velocity.is_known());
  CHECK(velocity.sigma() == Approx(0.06));
  velocity.set_latest(covariance(0.01, 0.2), 3);
  CHECK(velocity.sigma() == 0.1);
  CHECK_FALSE(velocity.is_known());
  velocity.set_latest(covariance(0.01, 0.02), 3);
  velocity.set_unknown();
  CHECK_FALSE(velocity.is_known());
}

TEST_CASE("velocity_uncertainty: the sigma of the speed is that along the velocity") {
  Velocity velocity(0.1);
  velocity.set_solved(covariance(0.03, 0.01), {2, 0, 0});
  CHECK(velocity.speed() == Approx(2));
  CHECK(velocity.speed_sigma() == Approx(0.03));
  velocity.set_solved(covariance(0.03, 0.01), {0, 0, -4});
  CHECK(velocity.speed_sigma() == Approx(0.01));
  velocity.reset_speed();
  CHECK(velocity.speed() == 0);
}

TEST_CASE("velocity_uncertainty: frames of an outage add up to the velocity error over its whole time") {
  Velocity velocity(0.1);
  velocity.set_solved(covariance(0.05, 0.02), {1, 0, 0});
  ImuIncrement<double> increment(Vec<double, 3>::Zero(), Vec<double, 3>::Zero());
  increment.duration = 0.05;
  Mat<double, 6, 6> P = Mat<double, 6, 6>::Zero();
  constexpr int frames = 20;
  for (int k = 1; k <= frames; ++k) P = velocity.grown(P, increment, 0.05 * k);
  const double t = 0.05 * frames;
  CHECK(P(3, 3) == Approx(0.05 * 0.05 * t * t + 0.1 * 0.1 * t + frames * increment.covariance(3, 3)));
  CHECK(P(0, 0) == Approx(frames * increment.covariance(0, 0)).margin(1e-12));
}
