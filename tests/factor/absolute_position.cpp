#include "plumbline/factor/absolute_position.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/state/frame_state.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using testing::jacobian_error;

namespace {
Mat<double, 3, 3> random_covariance(testing::Gaussian& normal, double sigma) {
  Mat<double, 3, 3> A;
  for (int c = 0; c < 3; ++c) A.col(c) = normal.vector<3>();
  return sigma * sigma * (A * A.transpose() + 0.1 * Mat<double, 3, 3>::Identity());
}
}  // namespace

TEMPLATE_TEST_CASE("absolute_position: Jacobian", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-5 : 1e-8;
  testing::Gaussian normal(1);
  for (int i = 0; i < 80; ++i) {
    // Also without a lever arm, with a long one, without rotation and with half a turn, and far from the origin.
    const double lever = i % 4 == 0 ? 0 : i % 4 == 1 ? 1e-6 : i % 4 == 2 ? 0.3 : 30;
    const double angle = i % 5 == 0 ? 0 : i % 5 == 1 ? 1e-7 : i % 5 == 2 ? std::numbers::pi - 1e-6 : 1;
    const double far = i % 3 == 0 ? 1e3 : 1;
    const Vec<double, 3> axis = normal.vector<3>().normalized();
    const SE3<double> T(SO3<double>::exp(angle * axis), far * normal.vector<3>());
    const Vec<double, 3> p_antenna = lever * normal.vector<3>(), p_measured = T.p() + normal.vector<3>();
    // As well known as 1 cm, as little as 10 m; along one axis 10^4 times better than along the others.
    Mat<double, 3, 3> covariance = random_covariance(normal, i % 2 == 0 ? 0.01 : 10);
    if (i % 7 == 0) covariance = 1e-8 * covariance + axis * axis.transpose();
    const auto factor = AbsolutePosition<double>::from_covariance(p_measured, covariance, p_antenna);
    REQUIRE(factor);
    const AbsolutePosition<S> given{p_measured.cast<S>(), factor->L.cast<S>(), p_antenna.cast<S>()};
    const PoseState<S> x{T.cast<S>()};
    const auto lin = given.linearize(x, x);
    REQUIRE(lin.valid);
    REQUIRE(lin.r == given.residual(x));
    REQUIRE(jacobian_error(
                lin.J_r_x, [&](const SE3<double>& at) { return factor->residual(PoseState<double>{at}); }, T) <
            tolerance);
  }
}

TEST_CASE("absolute_position: the residual is at the state, the Jacobian at the first estimate") {
  testing::Gaussian normal(2);
  const PoseState<double> x{{SO3<double>::exp(normal.vector<3>()), normal.vector<3>()}};
  const PoseState<double> x0{{SO3<double>::exp(normal.vector<3>()), normal.vector<3>()}};
  const auto factor =
      AbsolutePosition<double>::from_covariance(normal.vector<3>(), random_covariance(normal, 0.5), normal.vector<3>());
  REQUIRE(factor);
  const auto lin = factor->linearize(x, x0);
  CHECK(lin.r == factor->linearize(x, x).r);
  CHECK(lin.J_r_x == factor->linearize(x0, x0).J_r_x);
  CHECK(lin.J_r_x != factor->linearize(x, x).J_r_x);
}

TEMPLATE_TEST_CASE("absolute_position: whitened", "", float, double) {
  using S = TestType;
  testing::Gaussian normal(3);
  const Mat<double, 3, 3> covariance = random_covariance(normal, 0.5);
  const Vec<double, 3> e = normal.vector<3>();
  const auto factor = AbsolutePosition<S>::from_covariance(Vec<S, 3>(-e.cast<S>()), covariance.cast<S>());
  REQUIRE(factor);
  const PoseState<S> x{};
  CHECK(double(factor->residual(x).squaredNorm()) == Approx(e.dot(covariance.inverse() * e)).epsilon(1e-4));
}

TEST_CASE("absolute_position: what is no measurement is refused") {
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  const Mat<double, 3, 3> identity = Mat<double, 3, 3>::Identity(), flat = Vec<double, 3>(1, 1, 0).asDiagonal();
  using Factor = AbsolutePosition<double>;
  CHECK(!Factor::from_covariance({0, 0, 0}, flat));
  CHECK(!Factor::from_covariance({0, 0, 0}, nan * identity));
  CHECK(!Factor::from_covariance({0, 0, 0}, inf * identity));
  const PoseState<double> x{};
  CHECK(!Factor{{nan, 0, 0}, identity, {0, 0, 0}}.linearize(x, x).valid);
  CHECK(!Factor{{0, inf, 0}, identity, {0, 0, 0}}.linearize(x, x).valid);
  CHECK(!Factor{{0, 0, 0}, identity, {0, 0, nan}}.linearize(x, x).valid);
}
