#include "plumbline/imu/alignment_result.hpp"

#include <string_view>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("alignment_result: a contradiction is none of the outcomes that more motion resolves") {
  using enum AlignmentOutcome;
  for (const AlignmentOutcome outcome : {rotations_disagree, positions_disagree, gravity_implausible})
    CHECK(contradicts(outcome));
  for (const AlignmentOutcome outcome : {aligned, too_few_frames, no_imu_data, gravity_uncertain, scale_uncertain})
    CHECK_FALSE(contradicts(outcome));
  for (const AlignmentOutcome outcome : {aligned, too_few_frames, no_imu_data, rotations_disagree, positions_disagree,
                                         gravity_implausible, gravity_uncertain, scale_uncertain})
    CHECK(std::string_view(name_of(outcome)) != "unknown outcome");
}

TEST_CASE("alignment_result: uncertain only when there is an estimate, whose states are metric and upright") {
  InertialAlignment<double, 4> a;
  a.outcome = AlignmentOutcome::scale_uncertain;
  CHECK_FALSE(a.is_uncertain());
  a.v_world_body.push_back({1, 2, 3});
  CHECK(a.is_uncertain());
  CHECK_FALSE(bool(a));
  a.outcome = AlignmentOutcome::positions_disagree;
  CHECK_FALSE(a.is_uncertain());

  a.scale = 2;
  a.R_world_ref = SO3<double>::exp({0, 0, 1.5707963267948966});
  const SE3<double> T_body_cam(SO3<double>(), Vec<double, 3>(0, 0, 0.5));
  const NavState<double> x = a.state(0, SE3<double>({}, {1, 0, 0}), T_body_cam);
  CHECK((x.T_world_body.p() - Vec<double, 3>(0, 2, -0.5)).norm() < 1e-12);
  CHECK(x.v_world_body == Vec<double, 3>(1, 2, 3));
}
