#include "plumbline/imu/alignment_options.hpp"

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"
#include "plumbline/imu/alignment.hpp"

using namespace plumbline;

TEST_CASE("alignment_options: each limit has an outcome of its own") {
  const test::SimulatedAlignment<double> s(2, 0.5, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15});
  const InertialAlignmentOptions exact{.rotation_sigma = 1e-6, .position_sigma = 1e-6, .max_scale_sigma = 0.5};
  const auto outcome = [&](auto&& change) {
    InertialAlignmentOptions options = exact;
    change(options);
    return align_inertial<12>(s.span(), s.T_body_cam, options).outcome;
  };
  using Options = InertialAlignmentOptions;
  CHECK(outcome([](Options&) {}) == AlignmentOutcome::aligned);
  CHECK(outcome([](Options& o) { o.min_frames = 11; }) == AlignmentOutcome::too_few_frames);
  CHECK(outcome([](Options& o) { o.max_gyro_residual = -1; }) == AlignmentOutcome::rotations_disagree);
  CHECK(outcome([](Options& o) { o.max_chi2 = -1; }) == AlignmentOutcome::positions_disagree);
  CHECK(outcome([](Options& o) { o.max_gravity_sigma = -1; }) == AlignmentOutcome::gravity_uncertain);
  CHECK(outcome([](Options& o) { o.max_scale_sigma = -1; }) == AlignmentOutcome::scale_uncertain);
}
