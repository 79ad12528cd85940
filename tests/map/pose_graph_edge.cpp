#include "plumbline/map/pose_graph_edge.hpp"

#include <Eigen/LU>
#include <cmath>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("pose_graph_edge: whitened by its covariance", "", float, double) {
  using S = TestType;
  using Edge = PoseGraphEdge<RelativePoseResidual<S>>;
  testing::Gaussian normal(1);
  const auto random = [&] {
    return SE3<double>(SO3<double>::exp(0.5 * normal.vector<3>()), normal.vector<3>()).cast<S>();
  };
  const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-11;
  for (int turn = 0; turn < 20; ++turn) {
    Mat<double, 6, 6> C;
    for (int c = 0; c < 6; ++c) C.col(c) = 0.3 * normal.vector<6>();
    const Mat<double, 6, 6> Q = C * C.transpose() + Mat<double, 6, 6>::Identity();
    const SE3<S> T_i = random(), T_j = random(), measured = random();
    const auto edge = Edge::make(measured, Q.cast<S>());
    REQUIRE(edge);
    REQUIRE((edge->covariance().template cast<double>() - Q).norm() < tolerance * Q.norm());
    const auto lin = edge->residual.linearize(T_i, T_j);
    const auto rows = edge->template linearize<double>(T_i, T_j);
    const Vec<double, 6> r = lin.r.template cast<double>();
    REQUIRE(rows.r.squaredNorm() == Approx(r.dot(Q.inverse() * r)).epsilon(tolerance));
    REQUIRE(edge->template chi2<double>(T_i, T_j) == Approx(rows.r.squaredNorm()).epsilon(tolerance));
    const Mat<double, 6, 6> J_i = lin.J_r_i.template cast<double>(), J_j = lin.J_r_j.template cast<double>();
    REQUIRE((rows.J_i.transpose() * rows.J_j - J_i.transpose() * Q.inverse() * J_j).norm() < tolerance * 10);
  }
}

TEST_CASE("pose_graph_edge: what is refused, and what cannot be linearized") {
  using Edge = PoseGraphEdge<RelativePoseResidual<double>>;
  const SE3<double> T, bad(SO3<double>(), Vec<double, 3>(NAN, 0, 0));
  Edge::Covariance Q = Edge::Covariance::Identity();
  REQUIRE(Edge::make(bad, Q).error() == Error::not_finite);
  const auto edge = Edge::make(T, Q);
  const auto rows = edge->linearize<double>(T, bad);
  REQUIRE(std::isnan(rows.r.squaredNorm()));
  REQUIRE(rows.J_i.norm() == 0);
  REQUIRE(std::isnan(edge->chi2<double>(T, bad)));
  Q(3, 3) = 0;
  REQUIRE(Edge::make(T, Q).error() == Error::not_positive_definite);
  Q(3, 3) = INFINITY;
  REQUIRE(Edge::make(T, Q).error() == Error::not_finite);
}
