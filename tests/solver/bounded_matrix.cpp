#include "plumbline/solver/bounded_matrix.hpp"

#include <utility>

#include "catch.hpp"

using namespace plumbline;

TEST_CASE("bounded_matrix: is an Eigen expression of its current size") {
  BoundedMatrix<double, 200, 200> A;
  REQUIRE(A.size() == 0);
  A.resize(2, 3);
  A << 1, 2, 3, 4, 5, 6;
  REQUIRE(A.rows() == 2);
  REQUIRE(A.row(0).dot(A.row(1)) == 32.0);
  BoundedMatrix<double, 4, 4> B;
  B = A.transpose() * Eigen::Matrix2d::Identity();
  REQUIRE(B.rows() == 3);
  REQUIRE((B * A)(0, 2) == 27.0);
  A = Eigen::MatrixXd::Identity(200, 200);
  REQUIRE(A.trace() == 200.0);
}

TEST_CASE("bounded_matrix: copies own their values") {
  BoundedMatrix<float, 4, 4> A;
  A = Eigen::Matrix2f::Constant(3.0f);
  const BoundedMatrix<float, 4, 4> B = A;
  BoundedMatrix<float, 4, 4> C;
  C.resize(4, 4);
  C = A;
  A.setZero();
  REQUIRE(B.sum() == 12.0f);
  REQUIRE(C.rows() == 2);
  REQUIRE(C.sum() == 12.0f);
  BoundedMatrix<float, 4, 4> D = std::move(C);
  C.setZero();
  REQUIRE(D.sum() == 12.0f);
}
