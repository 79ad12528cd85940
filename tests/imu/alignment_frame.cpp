#include "plumbline/imu/alignment_frame.hpp"

#include <type_traits>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"
#include "plumbline/imu/alignment_rows.hpp"

using namespace plumbline;

namespace {

/// Cost of all rows after pose 4 has moved by `shift` in the axes of its body, which claims those sigmas.
template <class S>
double cost_after(const Vec<double, 3>& shift, const Vec<double, 3>& sigma) {
  test::SimulatedAlignment<S> s(4, 1, {0, 0, 0}, {0, 0, 0});
  auto& moved = s.frames[4];
  const SO3<double> R_ref_body = moved.T_ref_cam.rotation().template cast<double>() * s.T_body_cam.rotation().inverse();
  const Vec<double, 3> p = cast_to<double>(moved.T_ref_cam.p()) + R_ref_body * shift;
  moved.T_ref_cam = SE3<S>(moved.T_ref_cam.rotation(), cast_to<S>(p));
  for (int k = 0; k < 3; ++k) moved.position_covariance(k, k) = S(sigma[k] * sigma[k]);
  VelocityChain<12, AlignmentUnknowns::count> chain;
  chain.clear();
  const InertialAlignmentOptions options{.rotation_sigma = 1e-4, .position_sigma = 1e-3};
  for (std::size_t k = 1; k < s.frames.size(); ++k)
    REQUIRE(add_alignment_rows(chain, s.frames[k - 1], s.frames[k], s.T_body_cam, 1, options));
  REQUIRE(chain.solve());
  return chain.cost();
}

}  // namespace

TEST_CASE("alignment_frame: a pose begins without IMU samples and without noise of its own") {
  const AlignmentFrame<Preintegration<float>> frame;
  CHECK(frame.imu == nullptr);
  CHECK(frame.position_covariance.isZero(0));
  CHECK(frame.T_ref_cam.p().isZero(0));
  STATIC_REQUIRE(std::is_same_v<decltype(frame.T_ref_cam), SE3<float>>);
}

TEMPLATE_TEST_CASE("alignment_frame: the covariance of its position is in the axes of its body", "", float, double) {
  using S = TestType;
  const Vec<double, 3> none(0, 0, 0), x(0.2, 0, 0);
  const double exact = cost_after<S>(none, none), wrong = cost_after<S>(x, none);
  CHECK(exact < 1);
  CHECK(wrong > 100);
  CHECK(cost_after<S>(x, x) < 0.02 * wrong);                           // claimed where it is
  CHECK(cost_after<S>(x, Vec<double, 3>(0, 0.2, 0.2)) > 0.1 * wrong);  // claimed where it is not
  CHECK(cost_after<S>(Vec<double, 3>(0, 0.2, 0), x) > 0.1 * cost_after<S>(Vec<double, 3>(0, 0.2, 0), none));
}
