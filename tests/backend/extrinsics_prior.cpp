#include "plumbline/backend/extrinsics_prior.hpp"

#include <memory>

#include "catch.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

using Correction = ExtrinsicsPrior::Correction;
using Equations = NormalEquations<double, 15, 2>;

}  // namespace

TEST_CASE("extrinsics_prior: its gradient is that of its cost, of the extrinsics alone") {
  const ExtrinsicsPrior prior({});
  testing::Gaussian noise(1);
  for (int n = 0; n < 50; ++n) {
    const double size = n % 3 == 0 ? 1e-4 : n % 3 == 1 ? 5e-3 : 0.3;
    const Correction e = n == 0 ? Correction(Correction::Zero()) : Correction(size * noise.vector<6>());
    const auto equations = std::make_unique<Equations>();
    equations->reset(2);
    prior.add_to(e, 1, *equations);
    for (int k = 0; k < 6; ++k) {
      const double step = 1e-7;
      const Correction d = step * Correction::Unit(k);
      const double slope = (prior.cost(e + d) - prior.cost(e - d)) / (2 * step);
      CHECK(equations->b()[15 + k] == Approx(slope).epsilon(1e-5).margin(1e-3));
    }
    CHECK(equations->b().head<15>().norm() == 0);
    CHECK(equations->H().leftCols(15).norm() == 0);
  }
}

TEST_CASE("extrinsics_prior: a calibration without a sigma is fixed") {
  ExtrinsicsOptions known;
  known.rotation_sigma = known.position_sigma = 0;
  const auto equations = std::make_unique<Equations>();
  equations->reset(2);
  const ExtrinsicsPrior prior(known);
  prior.add_to(Correction::Zero(), 1, *equations);
  CHECK(equations->H().allFinite());
  CHECK(equations->H()(15, 15) > 1e11);
  CHECK(equations->H()(18, 18) > 1e11);
  CHECK(prior.cost(Correction::Zero()) == 0);
}

TEST_CASE("extrinsics_prior: fixed extrinsics keep their estimate, not the calibration") {
  ExtrinsicsPrior prior({});
  const Correction e = 0.01 * Correction::Ones();
  const auto step = [&] {
    const auto equations = std::make_unique<Equations>();
    equations->reset(2);
    prior.add_to(e, 1, *equations);
    return equations->b()[15] / equations->H()(15, 15);
  };
  const double free = step(), cost = prior.cost(e);
  prior.hold(true);
  CHECK(std::abs(step()) < 1e-5 * std::abs(free));
  CHECK(prior.cost(e) == cost);
  prior.hold(false);
  CHECK(step() == free);
}

TEST_CASE("extrinsics_prior: a calibration within its sigma has full weight, a wrong one little") {
  const ExtrinsicsOptions options;
  const ExtrinsicsPrior prior(options);
  const auto information = [&](double sigmas, int axis) {
    const auto equations = std::make_unique<Equations>();
    equations->reset(2);
    prior.add_to(sigmas * (axis < 3 ? options.rotation_sigma : options.position_sigma) * Correction::Unit(axis), 1,
                 *equations);
    return equations->H()(15 + axis, 15 + axis);
  };
  for (const int axis : {1, 4}) {
    const double sigma = axis < 3 ? options.rotation_sigma : options.position_sigma;
    CHECK(information(0, axis) == Approx(1 / (sigma * sigma)));
    CHECK(information(1, axis) > 0.8 * information(0, axis));
    CHECK(information(30, axis) < 0.011 * information(0, axis));
  }
}
