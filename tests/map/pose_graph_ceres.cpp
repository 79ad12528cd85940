// The pose graph against Ceres, whose residuals are written apart and differentiated automatically: one minimum.
#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include "catch.hpp"
#include "map/simulated_graph.hpp"
#include "plumbline/map/pose_graph_solver.hpp"

using namespace plumbline;

namespace {

constexpr double cauchy = 2.385;
const std::vector<test::LoopEnd> loops = {{0, 24}, {5, 29}, {31, 8}, {12, 13}, {8, 40}, {20, 44}};

template <class T>
using Quaternion = Eigen::Quaternion<T>;

/// A node: quaternion and position, and one number that is ln s (Sim(3)), the correction of the heading (4 dof), or 0.
struct Node {
  Vec<double, 4> q;
  Vec<double, 3> p;
  double extra = 0;
};

template <int Dim, class T>
struct State {
  Quaternion<T> q;
  Vec<T, 3> p;
  T s;
  State(const T* q_xyzw, const T* position, const T& extra) : q(q_xyzw), p(position), s(T(1)) {
    if constexpr (Dim == 7) s = exp(extra);
    if constexpr (Dim == 4) q = Quaternion<T>(Eigen::AngleAxis<T>(extra, Vec<T, 3>(T(0), T(0), T(1)))) * q;
  }
};

template <int Dim>
struct EdgeCost {
  Quaternion<double> q;
  Vec<double, 3> p;
  double s;
  Mat<double, Dim, Dim> L;

  template <class T>
  bool operator()(const T* q_i, const T* p_i, const T* x_i, const T* q_j, const T* p_j, const T* x_j, T* out) const {
    const State<Dim, T> i(q_i, p_i, *x_i), j(q_j, p_j, *x_j);
    const Quaternion<T> q_ij = i.q.conjugate() * j.q, to_j = q.cast<T>().conjugate();
    const Vec<T, 3> p_ij = i.q.conjugate() * Vec<T, 3>((j.p - i.p) / i.s);
    const Vec<T, 3> r_p = (to_j * Vec<T, 3>(p_ij - p.cast<T>())) / T(s);
    Vec<T, Dim> r;
    if constexpr (Dim == 4) {
      const Mat<T, 3, 3> M = (j.q * to_j * i.q.conjugate()).toRotationMatrix();
      r << atan2(M(1, 0) - M(0, 1), M(0, 0) + M(1, 1)), r_p;
    } else {
      const Quaternion<T> dq = to_j * q_ij;
      const T wxyz[4] = {dq.w(), dq.x(), dq.y(), dq.z()};
      T phi[3];
      ceres::QuaternionToAngleAxis(wxyz, phi);
      r.template head<6>() << phi[0], phi[1], phi[2], r_p;
      if constexpr (Dim == 7) r[6] = log(j.s / i.s / T(s));
    }
    Eigen::Map<Vec<T, Dim>> whitened(out);
    whitened = L.template cast<T>() * r;
    return true;
  }
};

template <class Pose>
Vec<double, 3> position(const Pose& T) {
  if constexpr (Pose::dof == 6) {
    return T.p();
  } else {
    return T.t();
  }
}
template <class Pose>
double scale(const Pose& T) {
  if constexpr (Pose::dof == 6) {
    return 1;
  } else {
    return T.scale();
  }
}

template <class World>
double solve_with_ceres(const World& world, std::vector<typename World::Pose>& poses) {
  constexpr int dim = World::Residual::dim;
  const auto& graph = *world.graph;
  std::vector<Node> nodes;
  for (int k = 0; k < graph.nodes(); ++k) {
    const auto& T = graph.pose(k);
    nodes.push_back({T.rotation().quaternion().coeffs(), position(T), dim == 7 ? std::log(scale(T)) : 0.0});
  }
  ceres::Problem problem;
  for (Node& node : nodes) {
    problem.AddParameterBlock(node.q.data(), 4, new ceres::EigenQuaternionManifold);
    problem.AddParameterBlock(node.p.data(), 3);
    problem.AddParameterBlock(&node.extra, 1);
    const bool first = &node == nodes.data();
    if (first || dim == 4) problem.SetParameterBlockConstant(node.q.data());
    if (first) problem.SetParameterBlockConstant(node.p.data());
    if (first || dim == 6) problem.SetParameterBlockConstant(&node.extra);
  }
  const auto add = [&](int i, int j, const auto& edge, ceres::LossFunction* loss) {
    const auto& T = edge.residual.measured;
    using Cost = EdgeCost<dim>;
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Cost, dim, 4, 3, 1, 4, 3, 1>(
                                 new Cost{T.rotation().quaternion(), position(T), scale(T), edge.L}),
                             loss, nodes[i].q.data(), nodes[i].p.data(), &nodes[i].extra, nodes[j].q.data(),
                             nodes[j].p.data(), &nodes[j].extra);
  };
  for (int k = 1; k < graph.nodes(); ++k) add(k - 1, k, graph.odometry(k), nullptr);
  for (int l = 0; l < graph.loops(); ++l) {
    add(graph.loop(l).i, graph.loop(l).j, graph.loop(l).edge, new ceres::CauchyLoss(cauchy));
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 500;
  options.function_tolerance = 1e-16;
  options.gradient_tolerance = 1e-13;
  options.parameter_tolerance = 1e-15;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  poses.clear();
  for (const Node& node : nodes) {
    SO3<double> R{Quaternion<double>(node.q.data())};
    if (dim == 4) R = SO3<double>::exp({0, 0, node.extra}) * R;
    poses.push_back(test::make_pose<typename World::Residual>(R, node.p, std::exp(dim == 7 ? node.extra : 0)));
  }
  return summary.final_cost;
}

}  // namespace

TEMPLATE_TEST_CASE("pose_graph: same minimum as Ceres", "", RelativePoseResidual<double>,
                   RelativePoseYawResidual<double>, RelativeSim3Residual<double>) {
  using World = test::SimulatedGraph<TestType>;
  for (const bool outlier : {false, true}) {
    World world(21, 46, loops);
    if (outlier) {
      Vec<double, TestType::dim> d = Vec<double, TestType::dim>::Constant(0.3);
      const auto wrong = world.truth[10].inverse() * TestType::moved(world.truth[35], d);
      REQUIRE(world.graph->add_loop(10, 35, wrong, World::covariance(world.sigma_loop)) ==
              PoseGraphInsertion::inserted);
    }
    std::vector<typename World::Pose> expected;
    const double expected_cost = solve_with_ceres(world, expected);
    const auto solver = std::make_unique<PoseGraphSolver<typename World::Graph>>();
    const LevenbergMarquardtOptions options{
        .max_iterations = 500, .relative_cost_tolerance = 1e-15, .step_tolerance = 1e-10};
    solver->begin(*world.graph, options, Cauchy<double>{cauchy});
    while (!solver->iterate(1000)) {
    }
    REQUIRE(solver->summary().initial_cost > 1.3 * expected_cost);
    REQUIRE(solver->summary().final_cost == Approx(expected_cost).epsilon(1e-6));
    for (int k = 0; k < world.graph->nodes(); ++k) {
      const auto difference =
          TestType{world.truth[0].inverse() * expected[k]}.residual(world.truth[0], solver->pose(k));
      REQUIRE(difference.norm() < 1e-5);
    }
  }
}
