#include "plumbline/solver/normal_equations.hpp"

#include <Eigen/LU>
#include <limits>
#include <memory>

#include "catch.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

constexpr int block_dim = 3, blocks = 5, dim = block_dim * blocks;

/// A random system, and the same rows in one dense matrix.
template <class T, class S = double>
struct System {
  std::unique_ptr<NormalEquations<S, block_dim, 8>> normal = std::make_unique<NormalEquations<S, block_dim, 8>>();
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dim, dim);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(dim);

  explicit System(std::uint64_t seed) {
    Random random(seed);
    normal->reset(blocks);
    for (int i = 0; i < blocks; ++i) {
      for (int j = 0; j < blocks; ++j) {
        const Mat<T, 2, 3> J_i = random_matrix<T, 2, 3>(random);
        const Mat<T, 2, 2> J_j = random_matrix<T, 2, 2>(random);  // leading parameters of block j only
        const Vec<T, 2> r = random_matrix<T, 2, 1>(random);
        const double w = random.uniform();
        Eigen::MatrixXd J = Eigen::MatrixXd::Zero(2, dim);
        J.block<2, 3>(0, 3 * i) = J_i.template cast<double>();
        if (i == j) {
          normal->add(i, J_i, r, S(w));
        } else {
          J.block<2, 2>(0, 3 * j) = J_j.template cast<double>();
          normal->add(i, J_i, j, J_j, r, S(w));
        }
        H += w * J.transpose() * J;
        b += w * J.transpose() * r.template cast<double>();
      }
    }
  }
};

}  // namespace

TEMPLATE_TEST_CASE("normal_equations: block rows give the dense sums", "", float, double) {
  const System<TestType> system(1);
  REQUIRE(system.normal->dim() == dim);
  REQUIRE(relative_error(symmetric(system.normal->H()), system.H) < 1e-14);  // accumulated in double also from float
  REQUIRE(relative_error(system.normal->b(), system.b) < 1e-14);
  REQUIRE(system.normal->cost() == 0.0);
}

TEST_CASE("normal_equations: cost is half the sum of rho, and reset clears everything") {
  System<float> system(2);
  system.normal->add_cost(3.0);
  system.normal->add_cost(4.0);
  REQUIRE(system.normal->cost() == 3.5);
  system.normal->reset(2);
  REQUIRE(system.normal->cost() == 0.0);
  REQUIRE(system.normal->dim() == 6);
  REQUIRE(system.normal->H().isZero(0));
  REQUIRE(system.normal->b().isZero(0));
}

TEST_CASE("normal_equations: damped step and its predicted decrease") {
  const System<double> system(3);
  NormalEquations<double, block_dim, 8>::Vector d;
  for (const double mu : {0.0, 1e-4, 1.0, 100.0}) {
    REQUIRE(system.normal->solve(mu, d));
    const Eigen::MatrixXd D = system.H.diagonal().asDiagonal();
    const Eigen::VectorXd expected = -(system.H + mu * D).inverse() * system.b;
    REQUIRE(relative_error(d, expected) < 1e-11);
    const double decrease = -d.dot(system.b) - d.dot(system.H * d) / 2;
    REQUIRE(system.normal->predicted_decrease(mu, d) == Approx(decrease).epsilon(1e-10));
  }
}

TEST_CASE("normal_equations: the damping is clipped") {
  NormalEquations<double, 1, 2> normal;
  normal.reset(2);
  normal.add(0, Mat<double, 1, 1>(1e5), Vec<double, 1>(1.0), 1.0);  // block 1: no information
  NormalEquations<double, 1, 2>::Vector d;
  REQUIRE_FALSE(normal.solve(0.0, d));
  REQUIRE(normal.solve(1e-3, d));
  REQUIRE(d[0] == Approx(-1e5 / (1e10 + 1e3)).epsilon(1e-12));
  REQUIRE(d[1] == 0.0);
}

TEST_CASE("normal_equations: refuses NaN, infinity and singular systems") {
  NormalEquations<double, block_dim, 8>::Vector d;
  Mat<double, 3, 3> covariance;
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    System<double> in_J(4), in_r(4);
    in_J.normal->add(1, Mat<double, 1, 3>(1, bad, 1), Vec<double, 1>(1.0), 1.0);
    REQUIRE_FALSE(in_J.normal->solve(1e-3, d));
    REQUIRE_FALSE(in_J.normal->covariance_block(0, covariance));
    in_r.normal->add(1, Mat<double, 1, 3>(1, 1, 1), Vec<double, 1>(bad), 1.0);
    REQUIRE_FALSE(in_r.normal->solve(1e-3, d));
  }
  NormalEquations<double, block_dim, 8> relative;  // only differences are measured: the mean is free
  relative.reset(3);
  const Mat<double, 3, 3> I = Mat<double, 3, 3>::Identity(), minus_I = -I;
  for (int i = 0; i < 2; ++i) relative.add(i, I, i + 1, minus_I, Vec<double, 3>(1, 2, 3), 0.3);
  REQUIRE_FALSE(relative.solve(0.0, d));
  REQUIRE_FALSE(relative.covariance_block(0, covariance));
  REQUIRE(relative.solve(1e-4, d));
}

TEST_CASE("normal_equations: covariance blocks are those of the inverse") {
  const System<double> system(5);
  const Eigen::MatrixXd inverse = system.H.inverse();
  for (int i = 0; i < blocks; ++i) {
    Mat<double, 3, 3> covariance;
    REQUIRE(system.normal->covariance_block(i, covariance));
    REQUIRE(relative_error(covariance, inverse.block<3, 3>(3 * i, 3 * i)) < 1e-10);
  }
}

TEST_CASE("normal_equations: the joint covariance of two blocks is that of the inverse") {
  const System<double> system(5);
  const Eigen::MatrixXd inverse = system.H.inverse();
  for (const std::array<int, 2>& pair : {std::array<int, 2>{0, 2}, {3, 1}, {blocks - 1, 0}}) {
    Mat<double, 6, 6> covariance;
    REQUIRE(system.normal->joint_covariance(pair, covariance));
    for (int a = 0; a < 2; ++a) {
      for (int b = 0; b < 2; ++b) {
        const Mat<double, 3, 3> block = covariance.block<3, 3>(3 * a, 3 * b);
        REQUIRE(relative_error(block, inverse.block<3, 3>(3 * pair[a], 3 * pair[b])) < 1e-10);
      }
    }
  }
}

TEST_CASE("normal_equations: takes prior information, and whole blocks") {
  Random random(6);
  System<double> system(7);
  const Eigen::MatrixXd J = random_matrix(random, dim, dim), known = J.transpose() * J;
  Eigen::MatrixXd lower = known;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());  // not read
  const Mat<double, 3, 3> B = random_matrix<double, 3, 3>(random);
  const Mat<double, 2, 2> C = random_matrix<double, 2, 2>(random);
  const Vec<double, 3> g = random_matrix<double, 3, 1>(random);
  const std::array<Vec<double, 2>, 1> a{random_matrix<double, 2, 1>(random)}, b{random_matrix<double, 2, 1>(random)};
  system.normal->reset(blocks);
  system.normal->add(lower);
  system.normal->add_block(3, 1, B);
  system.normal->add_block(4, 2, C);
  system.normal->subtract_product(4, a, 0, b);
  system.normal->add_gradient(2, g);
  system.normal->add_gradient(Eigen::VectorXd::Ones(dim));
  Eigen::MatrixXd H = known;
  H.block<3, 3>(9, 3) += B;
  H.block<2, 2>(12, 6) += C;
  H.block<2, 2>(12, 0) -= a[0] * b[0].transpose();
  Eigen::VectorXd gradient = Eigen::VectorXd::Ones(dim);
  gradient.segment<3>(6) += g;
  REQUIRE(relative_error(symmetric(system.normal->H()), Eigen::MatrixXd(H.selfadjointView<Eigen::Lower>())) < 1e-14);
  REQUIRE(relative_error(system.normal->b(), gradient) < 1e-14);
}

TEST_CASE("normal_equations: the order of elimination changes nothing") {
  System<double> system(9);
  NormalEquations<double, block_dim, 8>::Vector expected, d;
  Mat<double, 2, 2> covariance;
  REQUIRE(system.normal->solve(0.1, expected));
  NormalEquations<double, block_dim, 8>::Order order{};
  for (int k = 0; k < dim; ++k) order[std::size_t(k)] = std::int16_t((7 * k + 3) % dim);
  system.normal->set_order(order);
  REQUIRE(system.normal->solve(0.1, d));
  REQUIRE(relative_error(d, expected) < 1e-12);
  REQUIRE(system.normal->covariance_block(2, covariance));  // of the leading two parameters
  REQUIRE(relative_error(covariance, Eigen::MatrixXd(system.H.inverse()).block<2, 2>(6, 6)) < 1e-10);
}

TEST_CASE("normal_equations: all in float") {
  const System<float, float> system(8);
  NormalEquations<float, block_dim, 8>::Vector d;
  REQUIRE(system.normal->solve(0.0f, d));
  REQUIRE(relative_error(d.cast<double>(), -system.H.inverse() * system.b) < 1e-3);
}
