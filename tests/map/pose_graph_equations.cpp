#include "plumbline/map/pose_graph_equations.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <memory>
#include <type_traits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

template <class M>
M random_matrix(Random& random) {
  M out;
  for (int i = 0; i < out.size(); ++i) out.data()[i] = typename M::Scalar(2 * random.uniform() - 1);
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("pose_graph_equations: step, predicted decrease and covariance are those of the dense system", "",
                   float, double) {
  using S = TestType;
  constexpr int dim = 4, max_nodes = 25, max_loops = 8;
  using Equations = PoseGraphEquations<S, dim, max_nodes, max_loops>;
  using Block = typename Equations::Block;
  using Vector = typename Equations::Vector;
  const double tolerance = std::is_same_v<S, float> ? 2e-3 : 1e-10;
  const auto equations = std::make_unique<Equations>();
  Random random(3);
  for (int turn = 0; turn < 100; ++turn) {
    const int nodes = 2 + int(random.below(max_nodes - 1)), count = int(random.below(max_loops + 1));
    std::vector<std::array<int, 2>> loops;
    for (int l = 0; l < count; ++l) {
      const int i = int(random.below(std::uint32_t(nodes))), j = int(random.below(std::uint32_t(nodes)));
      if (i != j) loops.push_back({i, j});
    }
    const S mu = turn % 3 == 0 ? S(0) : S(0.1);
    equations->set_structure(nodes, int(loops.size()), [&](int l) { return loops[std::size_t(l)]; });
    equations->reset(mu);
    Eigen::MatrixXd H = Eigen::MatrixXd::Zero(dim * nodes, dim * nodes);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(dim * nodes);
    const auto rows = [&](int i, int j, double weight, auto&& add) {
      // not far from a regular matrix, so that float has something to agree with
      const Block J_i = S(0.2) * random_matrix<Block>(random) - Block::Identity(),
                  J_j = S(0.2) * random_matrix<Block>(random) + Block::Identity();
      const Vector r = random_matrix<Vector>(random);
      Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dim, dim * nodes);
      J.middleCols(dim * i, dim) = J_i.template cast<double>();
      J.middleCols(dim * j, dim) = J_j.template cast<double>();
      H += weight * J.transpose() * J;
      b += weight * J.transpose() * r.template cast<double>();
      add(J_i, J_j, r);
    };
    for (const auto& [i, j] : loops) {
      rows(i, j, 0.5, [&, i = i, j = j](const Block& J_i, const Block& J_j, const Vector& r) {
        equations->add_loop(i, j, J_i, J_j, r, S(0.5));
      });
    }
    bool ok = true;
    for (int k = 1; k < nodes; ++k) {
      rows(k - 1, k, 1, [&](const Block& J_i, const Block& J_j, const Vector& r) {
        ok = ok && equations->add_odometry(k, J_i, J_j, r);
      });
    }
    for (int p = 0; p < equations->ends(); ++p) ok = ok && equations->factorize_row(p);
    REQUIRE(ok);
    const int n = dim * (nodes - 1);
    const Eigen::MatrixXd reduced = H.bottomRightCorner(n, n);
    const Eigen::VectorXd gradient = b.tail(n), damping = double(mu) * reduced.diagonal();
    const Eigen::MatrixXd damped = reduced + Eigen::MatrixXd(damping.asDiagonal());
    const Eigen::MatrixXd covariance = damped.ldlt().solve(Eigen::MatrixXd::Identity(n, n));
    const Eigen::VectorXd d = -covariance * gradient;
    const double scale = 1 + d.norm();
    REQUIRE((equations->newest_covariance().template cast<double>() - covariance.bottomRightCorner<dim, dim>()).norm() <
            tolerance * (1 + covariance.norm()));
    for (int p = equations->ends() - 1; p >= 0; --p) equations->solve_end(p);
    for (int k = nodes - 1; k >= 1; --k) {
      REQUIRE((equations->step(k).template cast<double>() - d.segment<dim>(dim * (k - 1))).norm() < tolerance * scale);
    }
    const double decrease = -d.dot(gradient) - 0.5 * d.dot(reduced * d);
    REQUIRE(double(equations->predicted_decrease()) == Approx(decrease).epsilon(tolerance));
  }
}

TEST_CASE("pose_graph_equations: singular or not finite") {
  using Equations = PoseGraphEquations<double, 2, 4, 1>;
  const auto equations = std::make_unique<Equations>();
  const Mat<double, 2, 2> I = Mat<double, 2, 2>::Identity(), minus_I = -I, singular = Vec<double, 2>(1, 0).asDiagonal();
  const Vec<double, 2> r(1, 1);
  const auto factorize = [&](const Mat<double, 2, 2>& J) {
    equations->set_structure(4, 0, [](int) { return std::array<int, 2>{}; });
    equations->reset(0);
    bool ok = true;
    for (int k = 1; k < 4 && ok; ++k)
      ok = equations->add_odometry(k, k == 3 ? Mat<double, 2, 2>(-J) : minus_I, k == 3 ? J : I, r);
    return ok && equations->factorize_row(0);
  };
  REQUIRE(factorize(I));
  REQUIRE(!factorize(singular));
  REQUIRE(!factorize(Mat<double, 2, 2>(I * double(NAN))));
  REQUIRE(!factorize(Mat<double, 2, 2>(I * 1e200)));
}
