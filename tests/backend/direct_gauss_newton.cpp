// What the direct backend is, and that a frame alone is where the window would have it. Its errors against its
// covariance: consistency_direct.cpp.                                                              docs/math/direct.md
#include "plumbline/backend/direct_gauss_newton.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "backend/simulated_run.hpp"
#include "catch.hpp"
#include "plumbline/propagation/constant_velocity.hpp"

using namespace plumbline;

namespace {
template <class Sensors, int K>
using PointsOf = typename Features<Points<90>>::template Landmarks<Sensors, K>;
template <class Policy, class PropagationT>
using BackendOf =
    typename Policy::template Backend<PropagationT, PointsOf<typename PropagationT::Sensors, Policy::slots>>;

using Alone = ConstantVelocity<Rig<Rgbd<Pinhole<float>, 64 * 64>>>;
static_assert(Backend<BackendOf<DirectGaussNewton<5>, Inertial<test::MonoImu>>>);
static_assert(Backend<BackendOf<DirectGaussNewton<>, Alone>>);
static_assert(std::is_same_v<DirectGaussNewton<>::FrontEnds, DirectAlignment>);
static_assert(std::is_same_v<DirectGaussNewton<6, Flow>::FrontEnds, Flow>);
}  // namespace

TEST_CASE("direct_gauss_newton: without noise every frame is at the truth, keyframe or not") {
  test::RunOptions options;
  options.noise = 1e-3;
  test::BackendRun<DirectGaussNewton<8>, test::RgbdImu, Points<90>> run(3, options);
  for (int k = 0; k < 80; ++k) {
    const test::FrameError error = run.step();
    CAPTURE(k);
    REQUIRE(error.position < 2e-3);
    REQUIRE(error.rotation < 1e-3);
  }
  REQUIRE(run.retirements() > 5);
}

TEST_CASE("direct_gauss_newton: frames alone are about as good as frames in the window") {
  double alone = 0, together = 0;
  for (int seed = 1; seed <= 5; ++seed) {
    test::BackendRun<DirectGaussNewton<8>, test::MonoImu, Points<90>> direct{std::uint64_t(seed)};
    test::BackendRun<SlidingWindow<8>, test::MonoImu, Points<90>> window{std::uint64_t(seed)};
    for (int k = 0; k < 100; ++k) {
      const double a = direct.step().position, b = window.step().position;
      alone += a * a;
      together += b * b;
    }
  }
  CAPTURE(std::sqrt(alone / 500), std::sqrt(together / 500));
  CHECK(std::sqrt(alone / together) < 1.3);
}

TEST_CASE("direct_gauss_newton: after a visual outage the covariance is that of IMU-only propagation") {
  double nees = 0, worst = 0;
  constexpr int seeds = 10;
  for (int seed = 1; seed <= seeds; ++seed) {
    test::BackendRun<DirectGaussNewton<8>, test::RgbdImu, Points<90>> run{std::uint64_t(seed)};
    for (int k = 0; k < 30; ++k) run.step();
    run.black_out(40);             // 2 s
    for (int k = 0; k < 3; ++k) {  // none of them a keyframe
      const test::FrameError error = run.step();
      nees += error.nees_position / (3 * seeds);
      worst = std::max(worst, error.position);
    }
  }
  CAPTURE(nees, worst);
  CHECK(nees < 6);  // 3 expected
  CHECK(nees > 0.3);
}
