#include "plumbline/state/origin.hpp"

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

TEMPLATE_TEST_CASE("origin: an error of the place where all began moves every pose after it", "", float, double) {
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
      REQUIRE((carried(P, T, T_later) - moved * moved.transpose()).norm() < tolerance * (1 + moved.squaredNorm()));
    }
  }
}

TEMPLATE_TEST_CASE("origin: where gravity shows, place and heading stay open", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(2);
  const SE3<S> T = random_pose<S>(normal);
  const Mat<S, 6, 6> P = random_covariance<S>(normal), left = place_and_heading(P, T.rotation());
  const Mat<S, 3, 3> R = T.R();
  const Mat<S, 3, 3> before = R * block<3, 3>(P, 0, 0) * R.transpose(),
                     world = R * block<3, 3>(left, 0, 0) * R.transpose();
  Mat<S, 3, 3> expected = Mat<S, 3, 3>::Zero();
  expected(2, 2) = before(2, 2);
  CHECK((world - expected).norm() < S(1e-4) * before.norm());
  CHECK((block<3, 3>(left, 3, 3) - block<3, 3>(P, 3, 3)).norm() == 0);
  CHECK(block<3, 3>(left, 0, 3).norm() == 0);
}

TEMPLATE_TEST_CASE("origin: nothing is uncertain of the first one, doubts add up", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(3);
  const SE3<S> T = random_pose<S>(normal), T_later = random_pose<S>(normal);
  Origin<S> origin;
  CHECK(origin.at(T).norm() == 0);
  origin.doubt(T, S(0.3), S(0.01));
  origin.doubt(T, S(0.4), S(0));
  for (int k = 3; k < 6; ++k) CHECK(double(origin.at(T)(k, k)) == Approx(0.25));
  Mat<S, 3, 3> heading = Mat<S, 3, 3>::Zero();
  heading(2, 2) = S(1e-4);
  CHECK((T.R() * block<3, 3>(origin.at(T), 0, 0) * T.R().transpose() - heading).norm() < S(1e-6));
  const Mat<S, 6, 6> P = random_covariance<S>(normal);
  origin.set(T, P);
  CHECK((origin.at(T) - P).norm() < S(1e-4) * P.norm());
  CHECK((origin.at(T_later) - carried(P, T, T_later)).norm() < S(1e-4) * P.norm());
}

TEMPLATE_TEST_CASE("origin: what the calibration is wrong by grows with the way, there and back", "", float, double) {
  using S = TestType;
  Origin<S> origin(S(0.01));
  const auto sigma = [&](const SE3<S>& T, int k) { return std::sqrt(origin.at(T)(k, k)); };
  const SE3<S> turn(SO3<S>::exp({S(0), S(0.5), S(0)}), Vec<S, 3>::Zero()), step(SO3<S>(), {S(2), S(0), S(0)});
  origin.set(turn, Mat<S, 6, 6>::Zero());
  CHECK(origin.at(turn).norm() == 0);
  origin.travel_to(turn * step);
  CHECK(sigma(turn * step, 4) == Approx(0.02));
  CHECK(sigma(turn * step, 1) == 0);
  origin.travel_to(turn);
  origin.travel_to(SE3<S>());
  CHECK(sigma(SE3<S>(), 3) == Approx(0.04));
  CHECK(sigma(SE3<S>(), 2) == Approx(0.005));
  origin.set(SE3<S>(), Mat<S, 6, 6>::Zero());
  CHECK(origin.at(SE3<S>()).norm() == 0);
}

TEMPLATE_TEST_CASE("origin: a doubt on the way leaves the way, one that begins anew was none before", "", float,
                   double) {
  using S = TestType;
  Origin<S> origin(S(0.01));
  const auto at = [](double x) { return SE3<S>(SO3<S>(), {S(x), S(0), S(0)}); };
  origin.travel_to(at(3));
  origin.doubt_rotation(at(3), S(0.1));
  CHECK(double(origin.at(at(3))(3, 3)) == Approx(0.03 * 0.03));
  origin.travel_to(at(5));
  CHECK(double(origin.at(at(5))(4, 4)) == Approx(0.2 * 0.2 + 0.05 * 0.05));  // 2 m of which the direction is in doubt
  CHECK(double(origin.at(at(5))(5, 5)) == double(origin.at(at(5))(4, 4)));
  CHECK(double(origin.at(at(5))(0, 0)) == Approx(0.1 * 0.1));
  CHECK(double(origin.at(at(5))(3, 3)) == Approx(0.05 * 0.05));
  const Mat<S, 6, 6> P = origin.at(at(5));
  origin.begin_way(at(5));
  CHECK(double(origin.at(at(5))(4, 4)) == Approx(0.2 * 0.2));
  CHECK(origin.at(at(5))(2, 2) == P(2, 2));
}

TEMPLATE_TEST_CASE("origin: where gravity shows, the angle adds up about the vertical alone", "", float, double) {
  using S = TestType;
  Origin<S> origin(S(0.01), true);
  origin.set(SE3<S>(), Mat<S, 6, 6>::Zero());
  const SE3<S> T(SO3<S>::exp({S(0.3), S(-0.4), S(0)}), Vec<S, 3>::Zero());  // turns by 0.5, tilted
  origin.travel_to(T);
  Vec<S, 6> d = Vec<S, 6>::Zero();
  d[1] = S(0.002);
  origin.dispute(d);
  const Mat<S, 3, 3> in_world = T.R() * block<3, 3>(origin.at(T), 0, 0) * T.R().transpose();
  const Vec<S, 3> variances(S(0.002 * 0.002), S(0.002 * 0.002), S(0.007 * 0.007));
  CHECK((in_world - Mat<S, 3, 3>(variances.asDiagonal())).norm() < S(1e-9));
}

TEMPLATE_TEST_CASE("origin: what is in dispute adds up in one direction, until all begins anew", "", float, double) {
  using S = TestType;
  Origin<S> origin;
  Vec<S, 6> d = Vec<S, 6>::Zero();
  d[1] = S(0.01);
  d[5] = S(-0.03);
  origin.dispute(d);
  origin.dispute(-d);
  const SE3<S> T;
  CHECK(double(origin.at(T)(0, 0)) == Approx(0.02 * 0.02));
  CHECK(double(origin.at(T)(3, 3)) == Approx(0.06 * 0.06));
  origin.set(T, Mat<S, 6, 6>::Zero());
  CHECK(origin.at(T).norm() == 0);
}
