#include "plumbline/solver/relative_equations.hpp"

#include <Eigen/LU>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("relative_equations: the sums are those of the rows written out", "", float, double) {
  using S = TestType;
  constexpr int block_dim = 3, normal_dim = 4, blocks = 4, dim = normal_dim * blocks;
  Random random(1);
  RelativeEquations<double, block_dim, blocks> pairs;
  for (int a = 0; a < blocks; ++a) {
    for (int j = 0; j < blocks; ++j) {
      if (a != j) pairs.set_transport(a, j, random_matrix<double, block_dim, block_dim>(random));
    }
  }
  for (int round = 0; round < 2; ++round) {
    pairs.reset();
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dim, dim);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(dim);
    for (int n = 0; n < 20; ++n) {
      const int a = int(random.below(blocks)), j = int(random.below(blocks));
      const Mat<S, 2, block_dim> J = random_matrix<S, 2, block_dim>(random);
      const Vec<S, 2> r = random_matrix<S, 2, 1>(random);
      const Mat<S, block_dim, 2> by_parameter = J.transpose();
      pairs.template add<2>(a, j, by_parameter.data(), r.data());
      Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(2, dim);
      rows.block<2, block_dim>(0, j * normal_dim) = J.template cast<double>();
      if (a != j) rows.block<2, block_dim>(0, a * normal_dim) = -J.template cast<double>() * pairs.transport(a, j);
      H += rows.transpose() * rows;
      b += rows.transpose() * r.template cast<double>();
    }
    NormalEquations<double, normal_dim, blocks> normal;
    normal.reset(blocks);
    pairs.add_to(normal);
    REQUIRE(relative_error(symmetric(normal.H()), H) < 1e-14);
    REQUIRE(relative_error(normal.b(), b) < 1e-14);
  }
}

TEST_CASE("relative_equations: moving all blocks alike changes nothing, though the rows are float") {
  constexpr int blocks = 3;
  Random random(2);
  RelativeEquations<double, 6, blocks> pairs;
  pairs.reset();
  Mat<double, 6, 6> moved[blocks];  // M_ja = moved_j moved_a^-1
  for (auto& block : moved) block = random_matrix<double, 6, 6>(random);
  for (int a = 0; a < blocks; ++a) {
    for (int j = 0; j < blocks; ++j) {
      if (a == j) continue;
      pairs.set_transport(a, j, moved[j] * Eigen::MatrixXd(moved[a]).inverse());
      pairs.add<3>(a, j, random_matrix<float, 6, 3>(random).eval().data(),
                   random_matrix<float, 3, 1>(random).eval().data());
    }
  }
  NormalEquations<double, 6, blocks> normal;
  normal.reset(blocks);
  pairs.add_to(normal);
  Eigen::MatrixXd N(6 * blocks, 6);
  for (int k = 0; k < blocks; ++k) N.middleRows<6>(6 * k) = moved[k];
  const Eigen::MatrixXd H = symmetric(normal.H());
  REQUIRE((H * N).norm() < 1e-12 * H.norm() * N.norm());
}
