#pragma once
// What the comparisons of window solves with Ceres share: poses and the terms of points as Ceres sees them (analytic
// Jacobians), and the timer.

#include <benchmark/benchmark.h>
#ifdef PLUMBLINE_CERES
#include <ceres/ceres.h>
#endif

#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/residual/inverse_depth_point.hpp"
#include "plumbline/residual/relative_view.hpp"
#include "plumbline/sensor/depth_sensor.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

namespace plumbline::bench {

/// CPU time of this thread.
inline double seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return double(now.tv_sec) + 1e-9 * double(now.tv_nsec);
}

/// The times of all programs but the last one against that of the last one. A longest slice is no whole solve.
class Comparison : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration || run.benchmark_name().find("slice") != std::string::npos) continue;
      names_.push_back(run.benchmark_name());
      times_.push_back(run.GetAdjustedRealTime());
    }
  }
  void Finalize() override {
    for (std::size_t i = 0; i + 1 < times_.size(); ++i) {
      std::printf("%s is %.1f times as fast as %s\n", names_[i].c_str(), times_.back() / times_[i],
                  names_.back().c_str());
    }
  }

 private:
  std::vector<std::string> names_;
  std::vector<double> times_;
};

/// Solves copies of one window.
template <class Window>
void solve_window(benchmark::State& state) {
  const auto start = std::make_unique<Window>(), window = std::make_unique<Window>(*start);
  int iterations = 0;
  for (auto _ : state) {
    *window = *start;
    const double begin = seconds();
    iterations = window->solve().iterations;
    state.SetIterationTime(seconds() - begin);
  }
  state.counters["iterations"] = iterations;
}

template <template <class> class Window>
void register_solves(const std::string& name) {
  benchmark::RegisterBenchmark((name + "<float>").c_str(), solve_window<Window<float>>)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
  benchmark::RegisterBenchmark((name + "<double>").c_str(), solve_window<Window<double>>)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
}

#ifdef PLUMBLINE_CERES

/// A window as Ceres has it, and its solution with a dense Schur complement on one thread.
struct CeresProblem {
  ceres::Problem problem;
  ceres::Solver::Options options;
  ceres::Solver::Summary summary;

  CeresProblem() {
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.logging_type = ceres::SILENT;
  }
  double cost() {
    double out = 0;
    problem.Evaluate({}, &out, nullptr, nullptr, nullptr);
    return out;
  }
  int iterations() const { return summary.num_successful_steps + summary.num_unsuccessful_steps; }
  void solve() { ceres::Solve(options, &problem, &summary); }
};

/// Ours and Ceres start from the same cost and end at the same one, or their times mean nothing. Tolerances are
/// relative.
template <class Window, class CeresWindow>
bool agrees_with_ceres(const std::string& name, double tolerance_start, double tolerance) {
  const auto relative = [](double a, double b) { return std::abs(a - b) / b; };
  const auto ours = std::make_unique<Window>();
  CeresWindow with_ceres;
  const double start = with_ceres.cost();
  with_ceres.solve();
  const double expected = with_ceres.cost();
  const LevenbergMarquardtSummary summary = ours->solve();
  with_ceres.read(*ours);
  const double found = with_ceres.cost();
  std::printf("%-22s cost %.9g -> %.9g in %d iterations, Ceres %.9g -> %.9g in %d\n", name.c_str(),
              summary.initial_cost, found, summary.iterations, start, expected, with_ceres.iterations());
  return relative(summary.initial_cost, start) < tolerance_start && relative(found, expected) < tolerance;
}

/// The program: costs first, then times. `tolerance_start` is that of a first cost summed in float, `tolerance` that of
/// the last one.
template <template <class> class Window, class CeresWindow>
int compare(int argc, char** argv, const std::string& name, double tolerance_start, double tolerance = 1e-6) {
  benchmark::Initialize(&argc, argv);
  const bool float_agrees = agrees_with_ceres<Window<float>, CeresWindow>(name + "<float>", tolerance_start, tolerance);
  const bool double_agrees = agrees_with_ceres<Window<double>, CeresWindow>(name + "<double>", 1e-6, tolerance);
  if (!float_agrees || !double_agrees) {
    std::fprintf(stderr, "the costs differ\n");
    return 1;
  }
  register_solves<Window>(name);
  CeresWindow with_ceres;
  benchmark::RegisterBenchmark((name + "_ceres").c_str(),
                               [&](benchmark::State& state) {
                                 for (auto _ : state) {
                                   with_ceres.restart();
                                   const double begin = seconds();
                                   with_ceres.solve();
                                   state.SetIterationTime(seconds() - begin);
                                 }
                                 state.counters["iterations"] = with_ceres.iterations();
                               })
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
  Comparison comparison;
  benchmark::RunSpecifiedBenchmarks(&comparison);
  return 0;
}

/// Seven numbers [qx qy qz qw p] that move by our `plus`. Derivatives by its six numbers are put in the first six
/// columns of the ambient ones, so that no residual needs the derivative by a quaternion.
class PoseManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 7; }
  int TangentSize() const override { return 6; }
  bool Plus(const double* x, const double* d, double* out) const override {
    write(plus(read(x), Vec<double, 6>(Eigen::Map<const Vec<double, 6>>(d))), out);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> out(J);
    out.setIdentity();
    return true;
  }
  bool Minus(const double* y, const double* x, double* d) const override {
    Eigen::Map<Vec<double, 6>> out(d);
    out = minus(read(y), read(x));
    return true;
  }
  bool MinusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> out(J);
    out.setIdentity();
    return true;
  }
  static SE3<double> read(const double* x) {
    return SE3<double>(SO3<double>(Eigen::Quaterniond(x)), Eigen::Map<const Vec<double, 3>>(x + 4));
  }
  static void write(const SE3<double>& T, double* x) {
    Eigen::Map<Vec<double, 7>> out(x);
    out << T.rotation().quaternion().coeffs(), T.p();
  }
};

template <int Rows>
using PoseJacobian = Eigen::Map<Eigen::Matrix<double, Rows, 7, Eigen::RowMajor>>;

template <int Rows>
void write_pose_jacobian(const Mat<double, Rows, 6>& J, double* out) {
  if (out) PoseJacobian<Rows>(out) << J, Vec<double, Rows>::Zero();
}

template <int Rows>
void write_all(const AnchoredLinearization<double, Rows>& lin, const Mat<double, Rows, Rows>& L, double* r,
               double** J) {
  Eigen::Map<Vec<double, Rows>> out(r);
  out = L * lin.r;
  if (!J) return;
  write_pose_jacobian<Rows>(L * lin.J_r_anchor, J[0]);
  write_pose_jacobian<Rows>(L * lin.J_r_target, J[1]);
  if (J[2]) {
    Eigen::Map<Vec<double, Rows>> J_lambda(J[2]);
    J_lambda = L * lin.J_r_lambda;
  }
}

/// Pixel of a landmark in another keyframe than its anchor: anchor pose, target pose, inverse range.
struct PixelCost final : ceres::SizedCostFunction<2, 7, 7, 1> {
  const Pinhole<double>& camera;
  Vec<double, 3> bearing;
  Vec<double, 2> uv;
  Mat<double, 2, 2> L;
  template <class Observation>
  PixelCost(const Pinhole<double>& c, const Vec<double, 3>& b, const Observation& seen)
      : camera(c), bearing(b), uv(seen.uv.template cast<double>()), L(seen.L.template cast<double>()) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const RelativeView<double> view(PoseManifold::read(x[0]), PoseManifold::read(x[1]), SE3<double>());
    if (!J) {  // the value alone, as ours
      const Projection<double> projection = camera.project(view.scaled_point(bearing, x[2][0]));
      Eigen::Map<Vec<double, 2>> out(r);
      out = L * (projection.uv - uv);
      return projection.valid;
    }
    const auto lin = InverseDepthReprojection<Pinhole<double>>{uv}.linearize(camera, view, bearing, x[2][0]);
    if (lin.valid) write_all<2>(lin, L, r, J);
    return lin.valid;
  }
};

/// Inverse depth measured there.
struct DepthCost final : ceres::SizedCostFunction<1, 7, 7, 1> {
  Vec<double, 3> bearing;
  InverseDepth<double> depth;
  DepthCost(const Vec<double, 3>& b, const InverseDepth<double>& d) : bearing(b), depth(d) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const RelativeView<double> view(PoseManifold::read(x[0]), PoseManifold::read(x[1]), SE3<double>());
    if (!J) {
      r[0] = (x[2][0] / view.scaled_point(bearing, x[2][0]).z() - depth.value) / depth.sigma;
      return true;
    }
    const auto lin = InverseDepthMeasurement<double>{depth.value}.linearize(view, bearing, x[2][0]);
    if (lin.valid) write_all<1>(lin, Mat<double, 1, 1>(1 / depth.sigma), r, J);
    return lin.valid;
  }
};

/// Inverse depth measured in the anchor.
struct AnchorDepthCost final : ceres::SizedCostFunction<1, 1> {
  double bearing_z;
  InverseDepth<double> depth;
  AnchorDepthCost(double z, const InverseDepth<double>& d) : bearing_z(z), depth(d) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    r[0] = (x[0][0] / bearing_z - depth.value) / depth.sigma;
    if (J && J[0]) J[0][0] = 1 / (bearing_z * depth.sigma);
    return true;
  }
};

/// All residuals of one point between these poses.
template <class Landmark>
void add_point(CeresProblem& window, const Pinhole<double>& camera, const Landmark& landmark,
               std::vector<Vec<double, 7>>& poses, double* lambda) {
  const Vec<double, 3>& bearing = landmark.geometry.bearing;
  window.options.linear_solver_ordering->AddElementToGroup(lambda, 0);
  for (std::size_t slot = 0; slot < poses.size(); ++slot) {
    const auto& seen = landmark.observations[slot];
    if (!seen.valid) continue;
    if (int(slot) == landmark.anchor) {
      window.problem.AddResidualBlock(new AnchorDepthCost(bearing.z(), seen.depth.get()), new ceres::HuberLoss(1.345),
                                      lambda);
      continue;
    }
    double *const anchor = poses[std::size_t(landmark.anchor)].data(), *const target = poses[slot].data();
    window.problem.AddResidualBlock(new PixelCost(camera, bearing, seen), new ceres::HuberLoss(2.45), anchor, target,
                                    lambda);
    window.problem.AddResidualBlock(new DepthCost(bearing, seen.depth.get()), new ceres::HuberLoss(1.345), anchor,
                                    target, lambda);
  }
}

#endif

}  // namespace plumbline::bench
