#include "plumbline/imu/velocity_chain.hpp"

#include <Eigen/LU>
#include <Eigen/QR>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEST_CASE("velocity_chain: the solution, covariance and cost of dense least squares") {
  constexpr int frames = 6, N = 5, columns = 3 * frames + N;
  testing::Gaussian normal(1);
  VelocityChain<frames, N> chain;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(6 * (frames - 1) + 2, columns);
  Eigen::VectorXd rhs(J.rows());
  for (int i = 0; i < 2; ++i) {
    J.row(i).tail<N>() = normal.vector<N>().transpose();
    rhs[i] = normal();
    chain.add_common_row(J.row(i).tail<N>(), rhs[i]);
  }
  for (int k = 0; k + 1 < frames; ++k) {
    const int row = 2 + 6 * k;
    for (int c = 0; c < 6; ++c) J.col(3 * k + c).segment<6>(row) = normal.vector<6>();
    for (int c = 0; c < N; ++c) J.col(3 * frames + c).segment<6>(row) = normal.vector<6>();
    rhs.segment<6>(row) = normal.vector<6>();
    chain.add_interval(J.block<6, 3>(row, 3 * k), J.block<6, 3>(row, 3 * k + 3), J.block<6, N>(row, 3 * frames),
                       rhs.segment<6>(row));
  }
  REQUIRE(chain.solve());
  const Eigen::VectorXd x = J.householderQr().solve(rhs);
  REQUIRE((chain.common() - x.tail<N>()).norm() < 1e-12);
  for (int k = 0; k < frames; ++k) REQUIRE((chain.velocity(k) - x.segment<3>(3 * k)).norm() < 1e-12);
  REQUIRE(chain.cost() == Approx((J * x - rhs).squaredNorm()));
  const Eigen::MatrixXd covariance = (J.transpose() * J).inverse();
  REQUIRE((chain.covariance() - covariance.bottomRightCorner<N, N>()).norm() < 1e-10 * covariance.norm());
}

TEST_CASE("velocity_chain: nothing when undetermined") {
  VelocityChain<4, 1> chain;
  REQUIRE(!chain.solve());
  const Mat<double, 6, 3> A = Mat<double, 6, 3>::Random();
  chain.add_interval(A, 2 * A, Vec<double, 6>::Random(), Vec<double, 6>::Random());
  REQUIRE(!chain.solve());
}
