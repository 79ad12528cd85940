#include "plumbline/imu/alignment_rows.hpp"

#include <limits>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"

using namespace plumbline;

namespace {
using Chain = VelocityChain<12, AlignmentUnknowns::count>;
const InertialAlignmentOptions options{.rotation_sigma = 1e-6, .position_sigma = 1e-6};
}  // namespace

TEST_CASE("alignment_rows: exact poses and samples satisfy them with the true unknowns") {
  const double scale = 0.5;
  const test::SimulatedAlignment<double> s(4, scale, {0, 0, 0}, {0.1, 0.2, -0.15});
  Chain chain;
  chain.clear();
  for (std::size_t k = 1; k < s.frames.size(); ++k)
    REQUIRE(add_alignment_rows(chain, s.frames[k - 1], s.frames[k], s.T_body_cam, 1 / scale, options));
  REQUIRE(chain.solve());
  const double lambda = chain.common()[AlignmentUnknowns::lambda];
  CHECK(lambda == Approx(1 / scale).epsilon(1e-5));
  const Vec<double, 3> g = segment<3>(chain.common(), AlignmentUnknowns::g) / lambda;
  CHECK((g - s.R_ref_world * gravity_in_world<double>()).norm() < 1e-3);
  CHECK(chain.cost() < 1e-3);
}

TEST_CASE("alignment_rows: none where the covariance of the positions is not finite") {
  test::SimulatedAlignment<double> s(4, 1, {0, 0, 0}, {0, 0, 0});
  Chain chain;
  chain.clear();
  s.frames[1].position_covariance(0, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK_FALSE(add_alignment_rows(chain, s.frames[0], s.frames[1], s.T_body_cam, 1, options));
}
