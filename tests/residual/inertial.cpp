#include "plumbline/residual/inertial.hpp"

#include <Eigen/Cholesky>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "imu/random_motion.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;
using testing::jacobian_error;

namespace {

const Vec<double, 3> gravity(0, 0, -9.81);

struct Scene {
  ImuIncrement<double> increment;
  NavState<double> x_i, x_j;  ///< near the prediction of the increment

  explicit Scene(std::uint64_t seed, double error = 0.1) {
    testing::Gaussian normal(seed);
    const test::RandomMotion motion(normal);
    x_i = test::random_state(normal);
    increment =
        ImuIncrement<double>(x_i.bias_gyro + 0.01 * normal.vector<3>(), x_i.bias_accel + 0.1 * normal.vector<3>());
    test::for_each_interval(motion, 0, 500'000'000, 100,
                            [&](const ImuInterval<double>& d) { increment.integrate(d, {}); });
    x_j = plus(increment.predict(x_i, gravity), Vec<double, 15>(error * normal.vector<15>()));
  }
};

template <class S>
ImuIncrement<S> cast(const ImuIncrement<double>& d) {
  ImuIncrement<S> out(d.bias_gyro.cast<S>(), d.bias_accel.cast<S>());
  out.duration = S(d.duration);
  out.delta = {d.delta.dR.cast<S>(), d.delta.dp.cast<S>(), d.delta.dv.cast<S>()};
  out.covariance = d.covariance.cast<S>();
  out.J_delta_bias = d.J_delta_bias.cast<S>();
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("inertial: zero where the increment predicts, up to the biases", "", float, double) {
  using S = TestType;
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Scene s(seed, 0);
    const ImuIncrement<S> increment = cast<S>(s.increment);
    const InertialResidual<S> residual{increment, gravity.cast<S>()};
    REQUIRE(residual.linearize(s.x_i.cast<S>(), s.x_j.cast<S>()).r.norm() <
            (std::is_same_v<S, float> ? S(5e-6) : S(1e-13)));
  }
}

TEMPLATE_TEST_CASE("inertial: Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-5 : 1e-9;
  for (std::uint64_t seed = 1; seed < 40; ++seed) {
    const Scene s(seed, seed % 2 == 0 ? 0.1 : 1e-6);
    const ImuIncrement<S> increment = cast<S>(s.increment);
    const InertialResidual<S> residual{increment, gravity.cast<S>()};
    const typename InertialResidual<S>::Linearized lin = residual.linearize(s.x_i.cast<S>(), s.x_j.cast<S>());
    REQUIRE(lin.valid);
    const InertialResidual<double> reference{s.increment, gravity};
    REQUIRE(jacobian_error(
                lin.J_r_i, [&](const NavState<double>& x) { return reference.residual(x, s.x_j); }, s.x_i) < tolerance);
    REQUIRE(jacobian_error(
                lin.J_r_j, [&](const NavState<double>& x) { return reference.residual(s.x_i, x); }, s.x_j) < tolerance);
  }
}

TEST_CASE("inertial: first estimates") {
  const Scene s(3), first(4);
  const InertialResidual<double> residual{s.increment, gravity};
  const auto lin = residual.linearize(s.x_i, s.x_j, first.x_i, first.x_j);
  REQUIRE(lin.r == residual.linearize(s.x_i, s.x_j).r);
  REQUIRE(lin.J_r_i == residual.linearize(first.x_i, first.x_j).J_r_i);
  REQUIRE(lin.J_r_j == residual.linearize(first.x_i, first.x_j).J_r_j);
}

TEST_CASE("inertial: yaw about gravity and a shift of the world are not observed") {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    const Scene s(seed);
    const auto lin = InertialResidual<double>{s.increment, gravity}.linearize(s.x_i, s.x_j);
    const auto direction = [](const NavState<double>& x) {
      const Mat<double, 3, 3> Rt = x.T_world_body.R().transpose();
      const Vec<double, 3> z(0, 0, 1);
      Mat<double, 15, 4> N = Mat<double, 15, 4>::Zero();
      N.block<3, 1>(0, 0) = Rt * z;
      N.block<3, 1>(3, 0) = Rt * hat(z) * x.T_world_body.p();
      N.block<3, 1>(6, 0) = hat(z) * x.v_world_body;
      N.block<3, 3>(3, 1) = Rt;
      return N;
    };
    REQUIRE((lin.J_r_i * direction(s.x_i) + lin.J_r_j * direction(s.x_j)).norm() < 1e-12);
  }
}

TEMPLATE_TEST_CASE("inertial: whitened, the square is that of the information matrix", "", float, double) {
  using S = TestType;
  const Scene s(5, 1e-3);
  const ImuIncrement<S> increment = cast<S>(s.increment);
  typename InertialResidual<S>::Linearized lin =
      InertialResidual<S>{increment, gravity.cast<S>()}.linearize(s.x_i.cast<S>(), s.x_j.cast<S>());
  const Vec<double, 15> r = lin.r.template cast<double>();
  const Mat<double, 15, 15> J = lin.J_r_i.template cast<double>();
  lin.whiten(*increment.square_root_information());
  Mat<double, 15, 15> covariance = s.increment.covariance;
  covariance.diagonal().head<9>().array() += 1e-12;
  covariance.diagonal().tail<6>().array() += 1e-14;
  const Eigen::LDLT<Mat<double, 15, 15>> information(covariance);
  const double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-9;
  REQUIRE(double(lin.r.squaredNorm()) == Approx(r.dot(information.solve(r))).epsilon(tolerance));
  const Mat<double, 15, 15> H = J.transpose() * information.solve(J);
  const Mat<double, 15, 15> H_white = (lin.J_r_i.transpose() * lin.J_r_i).template cast<double>();
  REQUIRE((H - H_white).norm() < tolerance * H.norm());
}

TEST_CASE("inertial: nothing integrated, or not finite") {
  const ImuIncrement<double> empty;
  REQUIRE(!InertialResidual<double>{empty, gravity}.linearize({}, {}).valid);
  Scene s(6);
  const InertialResidual<double> residual{s.increment, gravity};
  s.x_j.v_world_body.x() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(!residual.linearize(s.x_i, s.x_j).valid);
}
