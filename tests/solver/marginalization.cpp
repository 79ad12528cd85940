#include "plumbline/solver/marginalization.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <Eigen/SVD>
#include <limits>
#include <memory>

#include "catch.hpp"
#include "plumbline/solver/landmark_elimination.hpp"
#include "plumbline/solver/normal_equations.hpp"
#include "random_matrix.hpp"

using namespace plumbline;

namespace {

/// Information and gradient left after [first, first + count) is eliminated from J^T J, J^T r.
struct Schur {
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
  Schur(const Eigen::MatrixXd& J, const Eigen::VectorXd& r, int first, int count) {
    const int dim = int(J.cols()), kept = dim - count;
    Eigen::MatrixXd Jm = J.middleCols(first, count), Jr(J.rows(), kept);
    Jr << J.leftCols(first), J.rightCols(kept - first);
    H = Jr.transpose() * Jr;
    b = Jr.transpose() * r;
    if (count == 0) return;
    const Eigen::MatrixXd K = Jr.transpose() * Jm * (Jm.transpose() * Jm).inverse();
    H -= K * Jm.transpose() * Jr;
    b -= K * Jm.transpose() * r;
  }
};

template <int N>
Eigen::MatrixXd information(const Prior<N>& prior) {
  return prior.J0.transpose() * prior.J0;
}
template <int N>
Eigen::VectorXd gradient(const Prior<N>& prior) {
  return prior.J0.transpose() * prior.r0;
}

}  // namespace

TEST_CASE("marginalization: equals the Schur prior, whatever the states") {
  Random random(1);
  const int dim = 14;
  const Eigen::MatrixXd J = random_matrix(random, 61, dim);
  const Eigen::VectorXd r = random_matrix(random, 61, 1);
  auto marginalizer = std::make_unique<Marginalizer<20, 8>>();
  for (const auto& [first, count] :
       {std::pair(0, 3), std::pair(5, 4), std::pair(11, 3), std::pair(4, 0), std::pair(0, 13)}) {
    marginalizer->reset(dim);
    marginalizer->add_rows(J.topRows(5), r.head(5));                // fewer rows than the buffer
    marginalizer->add_rows(J.middleRows(5, 40), r.segment(5, 40));  // several buffers
    marginalizer->add_rows(J.bottomRows(16), r.tail(16));
    Prior<20> prior;
    REQUIRE(marginalizer->marginalize(first, count, prior));
    const Schur expected(J, r, first, count);
    REQUIRE(prior.dim() == dim - count);
    REQUIRE(relative_error(information(prior), expected.H) < 1e-12);
    REQUIRE(relative_error(gradient(prior), expected.b) < 1e-12);
    REQUIRE(prior.J0.triangularView<Eigen::StrictlyLower>().toDenseMatrix().isZero(0));
    const Prior<20>::Vector e = random_matrix(random, prior.dim(), 1);
    REQUIRE(relative_error(prior.residual(e), prior.r0 + prior.J0 * e) < 1e-14);
  }
}

TEST_CASE("marginalization: sparse rows in any order give the same prior") {
  Random random(2);
  const int dim = 12;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(60, dim);
  const Eigen::VectorXd r = random_matrix(random, 60, 1);
  auto marginalizer = std::make_unique<Marginalizer<12, 4>>();
  marginalizer->reset(dim);
  for (int k = 0; k < 20; ++k) {
    const int i = 3 * int(random.below(4)), j = (i + 3) % dim;
    const Mat<float, 3, 3> J_i = random_matrix<float, 3, 3>(random), J_j = random_matrix<float, 3, 3>(random);
    J.block<3, 3>(3 * k, i) = J_i.cast<double>();
    if (k % 3 == 0) {
      marginalizer->add_rows(J_i, r.segment<3>(3 * k), i);
    } else {
      J.block<3, 3>(3 * k, j) = J_j.cast<double>();
      marginalizer->add_rows(J_i, i, J_j, j, r.segment<3>(3 * k));
    }
  }
  Prior<12> prior;
  REQUIRE(marginalizer->marginalize(3, 3, prior));
  const Schur expected(J, r, 3, 3);
  REQUIRE(relative_error(information(prior), expected.H) < 1e-12);
  REQUIRE(relative_error(gradient(prior), expected.b) < 1e-12);
}

TEST_CASE("marginalization: parameters that were not observed leave the others alone") {
  Random random(3);
  for (const int first : {0, 4}) {
    Eigen::MatrixXd J = random_matrix(random, 30, 9);
    const Eigen::VectorXd r = random_matrix(random, 30, 1);
    J.col(first).setZero();                    // one of three: nothing
    J.col(first + 2) = -3 * J.col(first + 1);  // two of three: only their sum
    auto marginalizer = std::make_unique<Marginalizer<9, 16>>();
    marginalizer->reset(9);
    marginalizer->add_rows(J, r);
    Prior<9> prior;
    REQUIRE(marginalizer->marginalize(first, 3, prior));
    Eigen::MatrixXd regular(30, 7);  // what remains when the redundant two are left out
    regular << J.leftCols(first), J.col(first + 1), J.rightCols(6 - first);
    const Schur expected(regular, r, first, 1);
    REQUIRE(relative_error(information(prior), expected.H) < 1e-12);
    REQUIRE(relative_error(gradient(prior), expected.b) < 1e-12);
  }
}

TEST_CASE("marginalization: few rows, no rows, bad rows") {
  auto marginalizer = std::make_unique<Marginalizer<6, 4>>();
  Prior<6> prior;
  marginalizer->reset(6);
  REQUIRE(marginalizer->marginalize(0, 2, prior));
  REQUIRE(prior.J0.isZero(0));
  marginalizer->reset(6);
  marginalizer->add_rows(Eigen::RowVectorXd::Ones(6), Vec<double, 1>(2.0));
  REQUIRE(marginalizer->marginalize(0, 2, prior));
  REQUIRE(information(prior).norm() < 1e-15);  // the only row is spent on m
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    marginalizer->reset(6);
    marginalizer->add_rows(Eigen::MatrixXd::Identity(6, 6), Eigen::VectorXd::Ones(6));
    marginalizer->add_rows(Eigen::RowVectorXd::Constant(6, bad), Vec<double, 1>(2.0));
    REQUIRE_FALSE(marginalizer->marginalize(0, 2, prior));
    REQUIRE(prior.empty());
  }
}

TEST_CASE("marginalization: a chain, one state at a time, ends like the whole at once") {
  Random random(4);
  constexpr int n = 3, states = 12;
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(n * states, n * states);
  const Eigen::VectorXd r = random_matrix(random, n * states, 1);
  J.topLeftCorner<n, n>().setIdentity();
  auto marginalizer = std::make_unique<Marginalizer<2 * n, 5>>();
  Prior<2 * n> prior;
  prior.J0 = Mat<double, n, n>::Identity();
  prior.r0 = r.head<n>();
  for (int k = 1; k < states; ++k) {
    const Mat<double, n, n> F = random_matrix<double, n, n>(random), G = random_matrix<double, n, n>(random);
    J.block<n, n>(k * n, (k - 1) * n) = F;
    J.block<n, n>(k * n, k * n) = G;
    marginalizer->reset(2 * n);
    marginalizer->add_rows(prior.J0, prior.r0);
    marginalizer->add_rows(F, 0, G, n, r.segment<n>(k * n));
    REQUIRE(marginalizer->marginalize(0, n, prior));
  }
  const Schur expected(J, r, 0, n * (states - 1));
  REQUIRE(relative_error(information(prior), expected.H) < 1e-8);  // the reference loses digits, not the prior
  const Eigen::VectorXd batch = J.inverse() * r;
  REQUIRE(relative_error(Eigen::MatrixXd(prior.J0).inverse() * prior.r0, batch.tail<n>()) < 1e-9);
}

TEST_CASE("marginalization: the prior does not observe the gauge") {
  // Planar SLAM: poses (phi, p), points X, measured r = R^T (X - p) - z. Free: the position and the angle of
  // everything.
  Random random(5);
  constexpr int poses = 6, points = 30;
  const Eigen::Matrix2d turn = (Eigen::Matrix2d() << 0, -1, 1, 0).finished();  // turn x = z-axis x x
  Eigen::Matrix2d R[poses];
  Eigen::Vector2d p[poses];
  Eigen::MatrixXd N(3 * poses, 3);  // columns: angle, shift in x, shift in y
  for (int k = 0; k < poses; ++k) {
    R[k] = Eigen::Rotation2Dd(random.uniform()).toRotationMatrix();
    p[k] = Eigen::Vector2d(k, random.uniform());
    N.row(3 * k) << 1, 0, 0;
    N.block<2, 3>(3 * k + 1, 0) << R[k].transpose() * turn * p[k], R[k].transpose();
  }
  // Points 0..14 are seen by poses 0..3 and leave with pose 0; 15..29 by poses 1..5 and leave with pose 1.
  const auto reduced = [&](int l, int first_pose, int last_pose, auto&& marginalizer) {
    LandmarkElimination<double, 2, 3, poses, 2 * poses> landmark;
    const Eigen::Vector2d X{3 * random.uniform(), 10 * random.uniform()};
    for (int k = first_pose; k <= last_pose; ++k) {
      const Eigen::Vector2d q = R[k].transpose() * (X - p[k]);
      Mat<double, 2, 3> J_pose;
      J_pose << -turn * q, -Eigen::Matrix2d::Identity();
      REQUIRE(landmark.add(k - (l < 15 ? 0 : 1), J_pose, Mat<double, 2, 2>(R[k].transpose()),
                           random_matrix<double, 2, 1>(random)));
    }
    const int dim = marginalizer.dim();
    Eigen::MatrixXd work(2 * poses, 2 + dim + 1);
    const int rank = landmark.reduced_rows(work, RelativeEquations<double, 3, poses>()), n = landmark.rows() - rank;
    marginalizer.add_rows(work.block(rank, 2, n, dim), work.col(2 + dim).segment(rank, n));
  };
  auto marginalizer = std::make_unique<Marginalizer<3 * poses, 16>>();
  Prior<3 * poses> prior;
  const auto check = [&](const Eigen::MatrixXd& null_space) {
    const Eigen::MatrixXd J0 = prior.J0;
    REQUIRE((J0 * null_space).norm() < 1e-12 * J0.norm() * null_space.norm());
    const Eigen::VectorXd sigma = J0.jacobiSvd().singularValues();
    int observed = 0;
    while (observed < sigma.size() && sigma[observed] > 1e-9 * sigma[0]) ++observed;
    return observed;
  };
  marginalizer->reset(3 * poses);
  for (int l = 0; l < 15; ++l) reduced(l, 0, 3, *marginalizer);
  REQUIRE(marginalizer->marginalize(0, 3, prior));
  REQUIRE(check(N.bottomRows(3 * (poses - 1))) == 6);  // three of the five poses that stay, less the gauge
  marginalizer->reset(3 * (poses - 1));
  marginalizer->add_rows(prior.J0, prior.r0);
  for (int l = 15; l < points; ++l) reduced(l, 1, 5, *marginalizer);
  REQUIRE(marginalizer->marginalize(0, 3, prior));
  REQUIRE(check(N.bottomRows(3 * (poses - 2))) == 9);  // all four, less the gauge
}

TEST_CASE("marginalization: information of a prior") {
  Random random(12);
  for (const bool triangular : {false, true}) {
    Prior<9> prior;
    Eigen::MatrixXd J0 = random_matrix(random, 7, 9);
    if (triangular) J0.triangularView<Eigen::StrictlyLower>().setZero();
    J0.col(4).setZero();
    prior.J0 = J0;
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(9, 9);
    prior.information(H);
    REQUIRE(relative_error(symmetric(H), J0.transpose() * J0) < 1e-14);
  }
}

TEST_CASE("marginalization: columns without information") {
  Random random(13);
  Prior<9> prior, wide;
  prior.J0 = random_matrix(random, 5, 6);
  prior.r0 = random_matrix(random, 5, 1);
  wide.widen(prior, 2, 3);
  REQUIRE(wide.J0.leftCols(2) == prior.J0.leftCols(2));
  REQUIRE(wide.J0.middleCols(2, 3).isZero(0));
  REQUIRE(wide.J0.rightCols(4) == prior.J0.rightCols(4));
  REQUIRE(wide.r0 == prior.r0);
  REQUIRE(wide.knows(4, 3));
  REQUIRE_FALSE(wide.knows(2, 3));
  wide.forget(5, 2);
  REQUIRE_FALSE(wide.knows(2, 5));
  const Eigen::VectorXd expected = prior.J0.transpose() * prior.r0;
  REQUIRE(relative_error(prior.gradient(prior.r0), expected) < 1e-14);
}
