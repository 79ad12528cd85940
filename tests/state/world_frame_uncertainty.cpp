#include "plumbline/state/world_frame_uncertainty.hpp"

#include <cmath>

#include "catch.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

namespace {

template <class S>
SE3<S> random_pose(testing::Gaussian& normal) {
  return plus(SE3<S>(), Vec<S, 6>(normal.vector<6>().cast<S>()));
}
template <class S>
Mat<S, 6, 6> random_covariance(testing::Gaussian& normal) {
  Mat<S, 6, 6> A;
  for (int k = 0; k < 6; ++k) A.col(k) = normal.vector<6>().cast<S>();
  return A * A.transpose();
}

}  // namespace

TEMPLATE_TEST_CASE("world_frame_uncertainty: an error of the initial pose moves every later pose", "", float, double) {
  using S = TestType;
  const S step = std::is_same_v<S, float> ? S(1e-3) : S(1e-6), tolerance = std::is_same_v<S, float> ? S(2e-2) : S(1e-4);
  testing::Gaussian normal(1);
  for (int trial = 0; trial < 20; ++trial) {
    const SE3<S> T = random_pose<S>(normal), T_later = random_pose<S>(normal), T_between = T.inverse() * T_later;
    for (int k = 0; k < 6; ++k) {
      Vec<S, 6> d = Vec<S, 6>::Zero();
      d[k] = step;
      const Vec<S, 6> moved = minus(plus(T, d) * T_between, T_later) / step;
      Mat<S, 6, 6> P = Mat<S, 6, 6>::Zero();
      P(k, k) = S(1);
      REQUIRE((transported(P, T, T_later) - moved * moved.transpose()).norm() < tolerance * (1 + moved.squaredNorm()));
    }
  }
}

TEMPLATE_TEST_CASE("world_frame_uncertainty: with gravity only position and heading are uncertain", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(2);
  const SE3<S> T = random_pose<S>(normal);
  const Mat<S, 6, 6> P = random_covariance<S>(normal), left = position_and_heading(P, T.rotation());
  const Mat<S, 3, 3> R = T.R();
  const Mat<S, 3, 3> before = R * block<3, 3>(P, 0, 0) * R.transpose(),
                     world = R * block<3, 3>(left, 0, 0) * R.transpose();
  Mat<S, 3, 3> expected = Mat<S, 3, 3>::Zero();
  expected(2, 2) = before(2, 2);
  CHECK((world - expected).norm() < S(1e-4) * before.norm());
  CHECK((block<3, 3>(left, 3, 3) - block<3, 3>(P, 3, 3)).norm() == 0);
  CHECK(block<3, 3>(left, 0, 3).norm() == 0);
}

TEMPLATE_TEST_CASE("world_frame_uncertainty: zero at first, variances add up", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(3);
  const SE3<S> T = random_pose<S>(normal), T_later = random_pose<S>(normal);
  WorldFrameUncertainty<S> uncertainty;
  CHECK(uncertainty.at(T).norm() == 0);
  uncertainty.add_uncertainty(T, S(0.3), S(0.01));
  uncertainty.add_uncertainty(T, S(0.4), S(0));
  for (int k = 3; k < 6; ++k) CHECK(double(uncertainty.at(T)(k, k)) == Approx(0.25));
  Mat<S, 3, 3> heading = Mat<S, 3, 3>::Zero();
  heading(2, 2) = S(1e-4);
  CHECK((T.R() * block<3, 3>(uncertainty.at(T), 0, 0) * T.R().transpose() - heading).norm() < S(1e-6));
  const Mat<S, 6, 6> P = random_covariance<S>(normal);
  uncertainty.set(T, P);
  CHECK((uncertainty.at(T) - P).norm() < S(1e-4) * P.norm());
  CHECK((uncertainty.at(T_later) - transported(P, T, T_later)).norm() < S(1e-4) * P.norm());
}

TEMPLATE_TEST_CASE("world_frame_uncertainty: the calibration error grows with the path length", "", float, double) {
  using S = TestType;
  WorldFrameUncertainty<S> uncertainty(S(0.01));
  const auto sigma = [&](const SE3<S>& T, int k) { return std::sqrt(uncertainty.at(T)(k, k)); };
  const SE3<S> turn(SO3<S>::exp({S(0), S(0.5), S(0)}), Vec<S, 3>::Zero()), step(SO3<S>(), {S(2), S(0), S(0)});
  uncertainty.set(turn, Mat<S, 6, 6>::Zero());
  CHECK(uncertainty.at(turn).norm() == 0);
  uncertainty.move_to(turn * step);
  CHECK(sigma(turn * step, 4) == Approx(0.02));
  CHECK(sigma(turn * step, 1) == 0);
  uncertainty.move_to(turn);
  uncertainty.move_to(SE3<S>());
  CHECK(sigma(SE3<S>(), 3) == Approx(0.04));
  CHECK(sigma(SE3<S>(), 2) == Approx(0.005));
  uncertainty.set(SE3<S>(), Mat<S, 6, 6>::Zero());
  CHECK(uncertainty.at(SE3<S>()).norm() == 0);
}

TEMPLATE_TEST_CASE(
    "world_frame_uncertainty: an added rotation uncertainty leaves the previous path, restart_path resets it", "",
    float, double) {
  using S = TestType;
  WorldFrameUncertainty<S> uncertainty(S(0.01));
  const auto at = [](double x) { return SE3<S>(SO3<S>(), {S(x), S(0), S(0)}); };
  uncertainty.move_to(at(3));
  uncertainty.add_rotation_uncertainty(at(3), S(0.1));
  CHECK(double(uncertainty.at(at(3))(3, 3)) == Approx(0.03 * 0.03));
  uncertainty.move_to(at(5));
  CHECK(double(uncertainty.at(at(5))(4, 4)) == Approx(0.2 * 0.2 + 0.05 * 0.05));  // 2 m of uncertain direction
  CHECK(double(uncertainty.at(at(5))(5, 5)) == double(uncertainty.at(at(5))(4, 4)));
  CHECK(double(uncertainty.at(at(5))(0, 0)) == Approx(0.1 * 0.1));
  CHECK(double(uncertainty.at(at(5))(3, 3)) == Approx(0.05 * 0.05));
  const Mat<S, 6, 6> P = uncertainty.at(at(5));
  uncertainty.restart_path(at(5));
  CHECK(double(uncertainty.at(at(5))(4, 4)) == Approx(0.2 * 0.2));
  CHECK(uncertainty.at(at(5))(2, 2) == P(2, 2));
}

TEMPLATE_TEST_CASE("world_frame_uncertainty: with gravity only the yaw error accumulates", "", float, double) {
  using S = TestType;
  WorldFrameUncertainty<S> uncertainty(S(0.01), true);
  uncertainty.set(SE3<S>(), Mat<S, 6, 6>::Zero());
  const SE3<S> T(SO3<S>::exp({S(0.3), S(-0.4), S(0)}), Vec<S, 3>::Zero());  // turns by 0.5, tilted
  uncertainty.move_to(T);
  Vec<S, 6> d = Vec<S, 6>::Zero();
  d[1] = S(0.002);
  uncertainty.inflate(d);
  const Mat<S, 3, 3> in_world = T.R() * block<3, 3>(uncertainty.at(T), 0, 0) * T.R().transpose();
  const Vec<S, 3> variances(S(0.002 * 0.002), S(0.002 * 0.002), S(0.007 * 0.007));
  CHECK((in_world - Mat<S, 3, 3>(variances.asDiagonal())).norm() < S(1e-9));
}

TEMPLATE_TEST_CASE("world_frame_uncertainty: inflation adds up in one direction until it is set", "", float, double) {
  using S = TestType;
  WorldFrameUncertainty<S> uncertainty;
  Vec<S, 6> d = Vec<S, 6>::Zero();
  d[1] = S(0.01);
  d[5] = S(-0.03);
  uncertainty.inflate(d);
  uncertainty.inflate(-d);
  const SE3<S> T;
  CHECK(double(uncertainty.at(T)(0, 0)) == Approx(0.02 * 0.02));
  CHECK(double(uncertainty.at(T)(3, 3)) == Approx(0.06 * 0.06));
  uncertainty.set(T, Mat<S, 6, 6>::Zero());
  CHECK(uncertainty.at(T).norm() == 0);
}
