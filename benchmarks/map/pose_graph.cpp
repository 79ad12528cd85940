// One solution of a pose graph: 500 keyframes in five laps, 20 loop closures, one of them wrong. Ceres solves the same
// graph (residuals, robust loss, start, tolerance; analytic Jacobians, sparse Cholesky, one thread); the program fails
// unless both reach the same cost.
#include "plumbline/map/pose_graph.hpp"

#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "plumbline/map/pose_graph_solver.hpp"
#include "plumbline/testing/gaussian.hpp"
#ifdef PLUMBLINE_CERES
#include <ceres/ceres.h>
#endif

namespace plumbline {
namespace {

constexpr int keyframes = 500, loops = 20, lap = 100;
constexpr LevenbergMarquardtOptions options{.max_iterations = 50, .relative_cost_tolerance = 1e-6};

/// CPU time of this thread.
double seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

template <class Residual>
struct Problem {
  using S = typename Residual::Scalar;
  using Pose = typename Residual::Pose;
  using Graph = PoseGraph<Residual, keyframes, loops>;
  using Vector = Vec<S, Residual::dim>;
  Graph graph;
  PoseGraphSolver<Graph> solver;

  Problem() {
    testing::Gaussian noise(1);
    std::vector<Pose> truth;
    for (int k = 0; k < keyframes; ++k) {
      const double angle = 2 * std::numbers::pi * k / lap;
      const SO3<double> R = SO3<double>::exp({0, 0, angle}) * SO3<double>::exp(0.1 * noise.vector<3>());
      const Vec<double, 3> p(8 * std::cos(angle), 8 * std::sin(angle), 0.5 * std::sin(0.1 * k));
      truth.push_back(pose(R, p));
    }
    Vector sigma;  // an angle, a position or ln s
    for (int n = 0; n < Residual::dim; ++n) sigma[n] = S(n < (Residual::dim == 4 ? 1 : 3) || n == 6 ? 0.002 : 0.01);
    const typename Graph::Covariance Q = Vector(sigma.cwiseProduct(sigma)).asDiagonal();
    const auto measured = [&](int i, int j) {
      Vector d;
      for (int n = 0; n < Residual::dim; ++n) d[n] = sigma[n] * S(noise());
      return truth[i].inverse() * Residual::moved(truth[j], d);
    };
    bool ok = graph.add_first(truth[0]) == PoseGraphInsertion::inserted;
    for (int k = 1; k < keyframes; ++k)
      ok = ok && graph.add_node(measured(k - 1, k), Q) == PoseGraphInsertion::inserted;
    for (int l = 0; l < loops; ++l) {
      const int i = int(noise.random().below(lap)), j = i + lap * int(1 + noise.random().below(4));
      Pose T = measured(i, j);
      if (l == 7) T = Residual::moved(T, Vector::Constant(S(0.2)));
      ok = ok && graph.add_loop(i, j, T, Q) == PoseGraphInsertion::inserted;
    }
    if (!ok) std::abort();
  }
  static Pose pose(const SO3<double>& R, const Vec<double, 3>& p) {
    if constexpr (std::is_same_v<Pose, SE3<S>>) {
      return SE3<double>(R, p).cast<S>();
    } else {
      return Sim3<double>(1, R, p).cast<S>();
    }
  }
  const LevenbergMarquardtSummary& solve() {
    solver.begin(graph, options);
    while (!solver.iterate(1000)) {
    }
    return solver.summary();
  }
};

template <class Residual>
void pose_graph_solve(benchmark::State& state) {
  const auto problem = std::make_unique<Problem<Residual>>();
  int iterations = 0;
  for (auto _ : state) {
    const double begin = seconds();
    iterations = problem->solve().iterations;
    state.SetIterationTime(seconds() - begin);
  }
  state.counters["iterations"] = iterations;
  state.counters["bytes_graph"] = sizeof(problem->graph);
  state.counters["bytes_solver"] = sizeof(problem->solver);
}
/// The longest of the slices of 200 units.
template <class Residual>
void pose_graph_longest_slice(benchmark::State& state) {
  const auto problem = std::make_unique<Problem<Residual>>();
  for (auto _ : state) {
    double longest = 0;
    problem->solver.begin(problem->graph, options);
    for (bool done = false; !done;) {
      const double begin = seconds();
      done = problem->solver.iterate(200);
      longest = std::max(longest, seconds() - begin);
    }
    state.SetIterationTime(longest);
  }
}

#ifdef PLUMBLINE_CERES

/// A pose as eight numbers [q xyzw, p, s] that move by `moved`. Derivatives by the increment stand in the first columns
/// of the ambient ones.
template <class Residual>
class NodeManifold final : public ceres::Manifold {
 public:
  using Pose = typename Residual::Pose;
  static constexpr int dim = Residual::dim;
  using Jacobian = Eigen::Matrix<double, 8, dim, Eigen::RowMajor>;
  int AmbientSize() const override { return 8; }
  int TangentSize() const override { return dim; }
  bool Plus(const double* x, const double* d, double* out) const override {
    write(Residual::moved(read(x), Vec<double, dim>(Eigen::Map<const Vec<double, dim>>(d))), out);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Jacobian>(J).setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
  static Pose read(const double* x) {
    const SO3<double> R{Eigen::Quaterniond(x)};
    const Vec<double, 3> p(x[4], x[5], x[6]);
    if constexpr (Pose::dof == 6) {
      return {R, p};
    } else {
      return {x[7], R, p};
    }
  }
  static void write(const Pose& T, double* x) {
    Vec<double, 8> out;
    if constexpr (Pose::dof == 6) {
      out << T.rotation().quaternion().coeffs(), T.p(), 1;
    } else {
      out << T.rotation().quaternion().coeffs(), T.t(), T.scale();
    }
    std::copy_n(out.data(), 8, x);
  }
};

template <class Residual>
struct EdgeCost final : ceres::SizedCostFunction<Residual::dim, 8, 8> {
  static constexpr int dim = Residual::dim;
  using Edge = typename Problem<Residual>::Graph::Edge;
  using Ambient = Eigen::Matrix<double, dim, 8, Eigen::RowMajor>;
  Edge edge;
  explicit EdgeCost(const Edge& e) : edge(e) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const auto T_i = NodeManifold<Residual>::read(x[0]), T_j = NodeManifold<Residual>::read(x[1]);
    Eigen::Map<Vec<double, dim>> out(r);
    if (!J) {
      out = edge.L * edge.residual.residual(T_i, T_j);
      return true;
    }
    const auto lin = edge.residual.linearize(T_i, T_j);
    out = edge.L * lin.r;
    write(J[0], edge.L * lin.J_r_i);
    write(J[1], edge.L * lin.J_r_j);
    return lin.valid;
  }
  static void write(double* out, const Mat<double, dim, dim>& J) {
    if (!out) return;
    Eigen::Map<Ambient> ambient(out);
    ambient.setZero();
    ambient.template leftCols<dim>() = J;
  }
};

template <class Residual>
struct CeresProblem {
  std::unique_ptr<Problem<Residual>> ours = std::make_unique<Problem<Residual>>();
  std::vector<Vec<double, 8>> nodes{keyframes};
  ceres::Problem problem;
  ceres::Solver::Options ceres_options;
  ceres::Solver::Summary summary;

  CeresProblem() {
    for (Vec<double, 8>& node : nodes) problem.AddParameterBlock(node.data(), 8, new NodeManifold<Residual>);
    problem.SetParameterBlockConstant(nodes[0].data());
    const auto add = [&](int i, int j, const auto& edge, ceres::LossFunction* loss) {
      problem.AddResidualBlock(new EdgeCost<Residual>(edge), loss, nodes[i].data(), nodes[j].data());
    };
    for (int k = 1; k < keyframes; ++k) add(k - 1, k, ours->graph.odometry(k), nullptr);
    for (int l = 0; l < loops; ++l) {
      const auto& loop = ours->graph.loop(l);
      add(loop.i, loop.j, loop.edge,
          new ceres::CauchyLoss(PoseGraphSolver<typename Problem<Residual>::Graph>::default_loss().c));
    }
    ceres_options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
    ceres_options.function_tolerance = options.relative_cost_tolerance;
    ceres_options.max_num_iterations = options.max_iterations;
    ceres_options.logging_type = ceres::SILENT;
  }
  void solve() { ceres::Solve(ceres_options, &problem, &summary); }
  void restart() {
    for (int k = 0; k < keyframes; ++k) NodeManifold<Residual>::write(ours->graph.pose(k), nodes[k].data());
  }
  bool agrees(const char* name) {
    restart();
    solve();
    const LevenbergMarquardtSummary found = ours->solve();
    std::printf("%-10s cost %.9g -> %.9g in %d iterations, Ceres %.9g -> %.9g in %d\n", name, found.initial_cost,
                found.final_cost, found.iterations, summary.initial_cost, summary.final_cost,
                summary.num_successful_steps + summary.num_unsuccessful_steps);
    return std::abs(found.initial_cost / summary.initial_cost - 1) < 1e-9 &&
           std::abs(found.final_cost / summary.final_cost - 1) < 1e-5;
  }
};

template <class Residual>
void pose_graph_ceres(benchmark::State& state) {
  CeresProblem<Residual> problem;
  for (auto _ : state) {
    problem.restart();
    const double begin = seconds();
    problem.solve();
    state.SetIterationTime(seconds() - begin);
  }
  state.counters["iterations"] = problem.summary.num_successful_steps + problem.summary.num_unsuccessful_steps;
}

#endif

template <template <class> class Residual>
void register_all(const std::string& name) {
  const auto add = [&](const std::string& what, void (*run)(benchmark::State&)) {
    benchmark::RegisterBenchmark((what + "<" + name + ">").c_str(), run)
        ->Unit(benchmark::kMillisecond)
        ->UseManualTime();
  };
  add("pose_graph_solve_float", pose_graph_solve<Residual<float>>);
  add("pose_graph_solve_double", pose_graph_solve<Residual<double>>);
  add("pose_graph_longest_slice", pose_graph_longest_slice<Residual<double>>);
#ifdef PLUMBLINE_CERES
  add("pose_graph_ceres", pose_graph_ceres<Residual<double>>);
#endif
}

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  using namespace plumbline;
  benchmark::Initialize(&argc, argv);
#ifdef PLUMBLINE_CERES
  const bool poses = CeresProblem<RelativePoseResidual<double>>().agrees("SE(3)");
  const bool headings = CeresProblem<RelativePoseYawResidual<double>>().agrees("4 dof");
  const bool similarities = CeresProblem<RelativeSim3Residual<double>>().agrees("Sim(3)");
  if (!poses || !headings || !similarities) {
    std::fprintf(stderr, "the costs differ\n");
    return 1;
  }
#endif
  register_all<RelativePoseResidual>("SE3");
  register_all<RelativePoseYawResidual>("yaw");
  register_all<RelativeSim3Residual>("Sim3");
  benchmark::RunSpecifiedBenchmarks();
}
