#include "plumbline/imu/alignment.hpp"

#include <cmath>
#include <string_view>
#include <type_traits>

#include "catch.hpp"
#include "imu/simulated_alignment.hpp"

using namespace plumbline;

namespace {

/// Exact poses, and a prior of the accelerometer bias that leaves it free.
const InertialAlignmentOptions exact_poses{
    .metric = false, .rotation_sigma = 0, .position_sigma = 1e-6, .accel_bias_sigma = 100, .max_scale_sigma = 0.5};

/// Largest error of gravity direction [rad], velocities [m/s] and biases, yaw apart.
template <class S, int MaxFrames>
double state_error(const InertialAlignment<S, MaxFrames>& a, const test::SimulatedAlignment<S>& s) {
  const Vec<double, 3> e3 = Vec<double, 3>::UnitZ();
  const SO3<double> R_world_ref = a.R_world_ref.template cast<double>();
  double worst = (R_world_ref * (s.R_ref_world * e3) - e3).norm();
  const SO3<double> yaw = R_world_ref * s.R_ref_world;  // the found world from the true one
  for (std::size_t k = 0; k < s.truth.size(); ++k) {
    worst = std::max(worst, (a.v_world_body[k].template cast<double>() - yaw * s.truth[k].v_world_body).norm());
    const NavState<double> x =
        a.state(k, s.frames[k].T_ref_cam, s.T_body_cam.template cast<S>()).template cast<double>();
    worst = std::max(worst, minus(x.T_world_body.rotation(), yaw * s.truth[k].T_world_body.rotation()).norm());
    const NavState<double> x0 =
        a.state(0, s.frames[0].T_ref_cam, s.T_body_cam.template cast<S>()).template cast<double>();
    worst = std::max(
        worst, (x.T_world_body.p() - x0.T_world_body.p() - yaw * Vec<double, 3>(s.truth[k].T_world_body.p())).norm());
  }
  worst = std::max(worst, (a.bias_gyro.template cast<double>() - s.truth[0].bias_gyro).norm());
  return std::max(worst, (a.bias_accel.template cast<double>() - s.truth[0].bias_accel).norm());
}

}  // namespace

TEMPLATE_TEST_CASE("alignment: everything from exact poses up to scale", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed < 10; ++seed) {
    for (const double scale : {0.3, 1.0, 7.0}) {
      const test::SimulatedAlignment<S> s(seed, scale, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15});
      InertialAlignmentOptions options = exact_poses;
      if (std::is_same_v<S, float>) options.position_sigma = 1e-5;
      const InertialAlignment<S, 12> a = align_inertial<12>(s.span(), s.T_body_cam.template cast<S>(), options);
      REQUIRE(a.outcome == AlignmentOutcome::aligned);
      REQUIRE(double(a.scale) == Approx(scale).epsilon(std::is_same_v<S, float> ? 1e-3 : 1e-5));
      REQUIRE(state_error(a, s) < (std::is_same_v<S, float> ? 1e-2 : 1e-4));
      REQUIRE((s.imu[3].increment().bias_accel == a.bias_accel && s.imu[3].increment().bias_gyro == a.bias_gyro));
    }
  }
}

TEMPLATE_TEST_CASE("alignment: metric poses", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed < 10; ++seed) {
    const test::SimulatedAlignment<S> s(seed, 1, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15});
    InertialAlignmentOptions options = exact_poses;
    options.metric = true;
    if (std::is_same_v<S, float>) options.position_sigma = 1e-5;
    const InertialAlignment<S, 10> a = align_inertial<10>(s.span(), s.T_body_cam.template cast<S>(), options);
    REQUIRE(a.outcome == AlignmentOutcome::aligned);
    REQUIRE(std::abs(a.scale - S(1)) < S(1e-5));
    REQUIRE(state_error(a, s) < (std::is_same_v<S, float> ? 5e-3 : 1e-4));
  }
}

TEST_CASE("alignment: sigmas are those of simulated noise") {
  testing::Gaussian normal(7);
  InertialAlignmentOptions options;
  options.max_scale_sigma = 1;
  double scale_squared = 0, gravity_squared = 0, chi2 = 0;
  constexpr int runs = 300;
  for (int run = 0; run < runs; ++run) {
    const Vec<double, 3> bias = options.accel_bias_sigma * normal.vector<3>();
    test::SimulatedAlignment<double> s(std::uint64_t(run + 1), 2, {0.02, -0.01, 0.05}, bias);
    for (AlignmentFrame<Preintegration<double>>& frame : s.frames)
      frame.T_ref_cam = plus(frame.T_ref_cam, (Vec<double, 6>() << options.rotation_sigma * normal.vector<3>(),
                                               options.position_sigma * normal.vector<3>())
                                                  .finished());
    const InertialAlignment<double, 10> a = align_inertial<10>(s.span(), s.T_body_cam, options);
    REQUIRE(a.outcome == AlignmentOutcome::aligned);
    scale_squared += std::pow((a.scale / 2 - 1) / a.scale_sigma, 2) / runs;
    const Vec<double, 3> e3 = Vec<double, 3>::UnitZ();
    gravity_squared += (a.R_world_ref * (s.R_ref_world * e3) - e3).squaredNorm() / std::pow(a.gravity_sigma, 2) / runs;
    chi2 += a.chi2 / runs;
  }
  CAPTURE(std::sqrt(scale_squared), std::sqrt(gravity_squared), chi2);
  // The noise of a pose enters two intervals; the solution treats the two as independent.
  REQUIRE((std::sqrt(scale_squared) > 0.5 && std::sqrt(scale_squared) < 1.5));
  REQUIRE((std::sqrt(gravity_squared) > 0.5 && std::sqrt(gravity_squared) < 1.5));
  REQUIRE((chi2 > 0.5 && chi2 < 1.5));
}

// As among white walls, where few corners are in sight: along its axis a camera is known worse, now and then by far.
TEST_CASE("alignment: poses are weighted by their covariance") {
  testing::Gaussian normal(8);
  InertialAlignmentOptions options;
  options.max_scale_sigma = 1;
  double known = 0, unknown = 0, chi2 = 0;
  int contradicted = 0;
  constexpr int runs = 200;
  for (int run = 0; run < runs; ++run) {
    test::SimulatedAlignment<double> s(std::uint64_t(run + 1), 2, {0.02, -0.01, 0.05}, {0.1, 0.2, -0.15});
    const SO3<double>& R_body_cam = s.T_body_cam.rotation();
    for (std::size_t k = 0; k < s.frames.size(); ++k) {
      const double away = (k % 3 == 1 ? 20 : 2) * options.position_sigma;
      Vec<double, 6> d = Vec<double, 6>::Zero();
      d.tail<3>() = options.position_sigma * normal.vector<3>();
      d[5] += away * normal.vector<3>()[0];
      s.frames[k].T_ref_cam = plus(s.frames[k].T_ref_cam, d);
      const Vec<double, 3> axis = R_body_cam * Vec<double, 3>(0, 0, away);
      s.frames[k].position_covariance = axis * axis.transpose();
    }
    const InertialAlignment<double, 10> a = align_inertial<10>(s.span(), s.T_body_cam, options);
    REQUIRE(a.outcome == AlignmentOutcome::aligned);
    known += std::pow(a.scale / 2 - 1, 2) / runs;
    chi2 += a.chi2 / runs;
    for (auto& frame : s.frames) frame.position_covariance.setZero();
    const InertialAlignment<double, 10> b = align_inertial<10>(s.span(), s.T_body_cam, options);
    contradicted += b.contradicts();
    unknown += std::pow(b.scale / 2 - 1, 2) / runs;
  }
  CAPTURE(std::sqrt(known), std::sqrt(unknown), chi2, contradicted);
  REQUIRE((chi2 > 0.3 && chi2 < 1.5));
  REQUIRE(contradicted > runs / 2);
  REQUIRE(known < unknown / 2);
}

TEST_CASE("alignment: reports the missing condition") {
  const Vec<double, 3> zero = Vec<double, 3>::Zero();
  {
    const test::SimulatedAlignment<double> s(1, 1, zero, zero, 4);
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam).outcome == AlignmentOutcome::too_few_frames);
  }
  {
    test::SimulatedAlignment<double> s(1, 1, zero, zero);
    s.imu[4] = Preintegration<double>();
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam).outcome == AlignmentOutcome::no_imu_data);
    s.frames[4].imu = nullptr;
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam).outcome == AlignmentOutcome::no_imu_data);
  }
  {
    const test::SimulatedAlignment<double> s(1, 1, zero, zero);
    REQUIRE(align_inertial<10>(s.span(), SE3<double>()).outcome == AlignmentOutcome::rotations_disagree);
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam, {}, 20).outcome == AlignmentOutcome::gravity_implausible);
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam, {.max_gravity_sigma = 1e-9}).outcome ==
            AlignmentOutcome::gravity_uncertain);
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam, {.max_scale_sigma = 1e-9}).outcome ==
            AlignmentOutcome::scale_uncertain);
  }
  {
    test::SimulatedAlignment<double> s(1, 1, zero, zero);
    const Vec<double, 3> turning_point = s.frames[5].T_ref_cam.p();  // from there on vision's unit is another
    for (std::size_t k = 6; k < s.frames.size(); ++k) {
      const SE3<double>& T = s.frames[k].T_ref_cam;
      s.frames[k].T_ref_cam = SE3<double>(T.rotation(), turning_point + 2 * (T.p() - turning_point));
    }
    const InertialAlignment<double, 10> a = align_inertial<10>(s.span(), s.T_body_cam);
    CAPTURE(a.chi2);
    REQUIRE((a.outcome == AlignmentOutcome::positions_disagree && !a.is_uncertain()));
  }
  {
    const test::SimulatedAlignment<double> s(1, 1, zero, zero, 10, false);
    const InertialAlignment<double, 10> a = align_inertial<10>(s.span(), s.T_body_cam);
    REQUIRE((a.outcome == AlignmentOutcome::scale_uncertain && a.excitation < 1e-9));  // it could have any
    REQUIRE((!a.is_uncertain() && std::string_view(name_of(a.outcome)) == "scale uncertain"));
    REQUIRE(align_inertial<10>(s.span(), s.T_body_cam, {.metric = true}).outcome == AlignmentOutcome::aligned);
  }
  {
    test::SimulatedAlignment<double> s(1, 1, zero, zero);
    s.frames[4].T_ref_cam = SE3<double>(s.frames[4].T_ref_cam.rotation(), {0, std::nan(""), 0});
    REQUIRE(!align_inertial<10>(s.span(), s.T_body_cam));
  }
}
