#include "plumbline/solver/landmark_system.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEST_CASE("landmark_system: elimination is the Schur complement of the dense system") {
  constexpr int dim = 3, block = 2, blocks = 4, n = block * blocks;
  testing::Gaussian noise(1);
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(20, dim + n);
  Eigen::VectorXd r(20);
  NormalEquations<double, block, blocks> normal;
  normal.reset(blocks);
  BlockSums<double, block, blocks> sums;
  sums.reset(blocks);
  LandmarkSystem<double, dim, block, blocks> system;
  system.reset();
  for (int k = 0; k < 20; ++k) {  // each row touches one block; blocks come out of order, and again
    const int i = std::array{1, 3, 3, 0, 1}[std::size_t(k % 5)];
    const Vec<double, dim> j = noise.vector<dim>();
    const Vec<double, block> j_i = noise.vector<block>();
    r[k] = noise();
    J.block<1, dim>(k, 0) = j.transpose();
    J.block<1, block>(k, dim + block * i) = j_i.transpose();
    system.H += j * j.transpose();
    system.b += j * r[k];
    for (int c = 0; c < dim; ++c) system.strip(i)[std::size_t(c)] += j_i * j[c];
    normal.add(i, Mat<double, 1, block>(j_i.transpose()), Vec<double, 1>(r[k]), 1.0);
  }
  CHECK(system.blocks() == 3);
  const double mu = 0.1;
  const Mat<double, dim, dim> H = system.H;
  LandmarkCholesky<double, dim> factor;
  REQUIRE(system.eliminate(mu, factor, sums));
  sums.add_to(normal);
  Eigen::MatrixXd full = J.transpose() * J;
  const Eigen::VectorXd b = J.transpose() * r;
  for (int k = 0; k < dim; ++k) full(k, k) += mu * H(k, k);
  const Eigen::MatrixXd W = full.bottomLeftCorner(n, dim);
  const Eigen::MatrixXd inverse = full.topLeftCorner(dim, dim).inverse();
  const Eigen::MatrixXd reduced = full.bottomRightCorner(n, n) - W * inverse * W.transpose();
  const Eigen::VectorXd g = b.tail(n) - W * inverse * b.head(dim);
  Eigen::MatrixXd found = normal.H().triangularView<Eigen::Lower>();
  CHECK((found - Eigen::MatrixXd(reduced.triangularView<Eigen::Lower>())).norm() < 1e-12);
  CHECK((normal.b() - g).norm() < 1e-12);

  const Eigen::VectorXd d = Eigen::VectorXd::Random(n);
  const Vec<double, dim> step = -inverse * (b.head(dim) + W.transpose() * d);
  CHECK((factor.step(Vec<double, dim>(W.transpose() * d)) - step).norm() < 1e-12);
  Vec<double, dim> by_strips = zeros<double, dim>();
  for (int m = 0; m < system.blocks(); ++m) {
    for (int c = 0; c < dim; ++c)
      by_strips[c] += system.at(m)[std::size_t(c)].dot(d.segment<block>(block * system.block(m)));
  }
  CHECK((factor.step_divided(by_strips) - step).norm() < 1e-12);
  const double decrease =
      0.5 * (b.head(dim).dot(inverse * b.head(dim)) + mu * step.dot(H.diagonal().cwiseProduct(step)));
  CHECK(factor.predicted_decrease(step) == Approx(decrease));
}

TEST_CASE("landmark_system: what is not finite has no factor, and changes nothing") {
  BlockSums<double, 2, 1> sums;
  sums.reset(1);
  LandmarkSystem<double, 2, 2, 1> system;
  LandmarkCholesky<double, 2> factor;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), -1.0}) {
    system.reset();
    set_identity(system.H);
    system.strip(0)[0] = {1, 2};
    system.H(1, 1) = bad;
    CHECK(!system.eliminate(0.1, factor, sums));
    CHECK(sums.H(0, 0)(0, 0) == 0);
  }
  system.reset();  // no rows: the damping alone
  REQUIRE(system.eliminate(0.1, factor, sums));
  CHECK(factor.step(zeros<double, 2>()).norm() == 0);
  CHECK(!system.eliminate(0, factor, sums));
}
