// One solve of a sliding window: 10 keyframes, 150 points, every point seen with its depth by every keyframe, 1 % of
// the pixels wrong. Ceres solves the same problem (residuals, robust losses, start, tolerance; analytic Jacobians,
// DENSE_SCHUR, one thread); the program fails unless both reach the same cost.
#include <benchmark/benchmark.h>
#ifdef PLUMBLINE_CERES
#include <ceres/ceres.h>
#endif

#include <chrono>
#include <cmath>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/testing/simulated_points.hpp"

namespace plumbline {
namespace {

constexpr int keyframes = 10, points = 150;
constexpr double cost_agreement = 1e-6;  // relative

template <class S>
struct Window {
  using Sensors = Rig<Rgbd<Pinhole<S>>>;
  using Map = typename Points<points>::Map<Sensors, keyframes>;
  using Maps = FeatureMaps<Map>;
  using Backend = WindowBackend<Sensors, Maps, keyframes>;

  Sensors rig;
  Maps maps{{}};
  Backend backend{{}};

  /// The first keyframe is exact, it defines the world; the others start 2 cm and 1 degree off.
  Window() {
    testing::SimulatedPoints scene;
    scene.outlier_share = 0.01;
    rig.vision.camera = {S(scene.camera.fx), S(scene.camera.fy), S(scene.camera.cx), S(scene.camera.cy), {}};
    scene.scatter(2 * points, {1.2, 0.9, 1.2}, 1);
    testing::Gaussian noise(2);
    for (int k = 0; k < keyframes; ++k) {
      const SE3<double> T(SO3<double>::exp({0.02 * k, -0.03 * k, 0.01 * k}), Vec<double, 3>(0.06 * k, 0.03 * k, -3.5));
      Vec<double, 6> error;
      error << 0.017 * noise.vector<3>(), 0.02 * noise.vector<3>();
      const SE3<S> start = plus(T, Vec<double, 6>(k == 0 ? 0 * error : error)).template cast<S>();
      const int slot = k == 0 ? backend.start(0, start) : backend.insert(k, start);
      maps.for_each([&](Map& map) { scene.observe(map, T, slot, noise); });
    }
  }
  const typename Map::Landmarks& landmarks() const { return maps.template get<Map>().landmarks(); }
};

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

template <class S>
void window_solve(benchmark::State& state) {
  const auto start = std::make_unique<Window<S>>(), window = std::make_unique<Window<S>>(*start);
  int iterations = 0;
  for (auto _ : state) {
    *window = *start;
    const double begin = seconds();
    iterations = window->backend.optimize(window->rig, window->maps).iterations;
    state.SetIterationTime(seconds() - begin);
  }
  state.counters["iterations"] = iterations;
}
BENCHMARK_TEMPLATE(window_solve, float)->Unit(benchmark::kMillisecond)->UseManualTime();
BENCHMARK_TEMPLATE(window_solve, double)->Unit(benchmark::kMillisecond)->UseManualTime();

#ifdef PLUMBLINE_CERES

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
  PixelCost(const Pinhole<double>& c, const Vec<double, 3>& b, const PointObservation<double>& seen)
      : camera(c), bearing(b), uv(seen.uv.cast<double>()), L(seen.L.cast<double>()) {}
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

struct FirstPoseCost final : ceres::SizedCostFunction<6, 7> {
  SE3<double> T_first;
  WindowOptions sigmas;
  explicit FirstPoseCost(const SE3<double>& T) : T_first(T) {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    Vec<double, 6> inverse_sigma;
    inverse_sigma << Vec<double, 3>::Constant(1 / sigmas.sigma_first_rotation),
        Vec<double, 3>::Constant(1 / sigmas.sigma_first_position);
    const SE3<double> T = PoseManifold::read(x[0]);
    Eigen::Map<Vec<double, 6>> out(r);
    out = inverse_sigma.cwiseProduct(minus(T, T_first));
    if (J) write_pose_jacobian<6>(inverse_sigma.asDiagonal() * minus_jacobian(T, T_first), J[0]);
    return true;
  }
};

struct CeresWindow {
  const Window<double>& window;  // the measurements
  std::vector<Vec<double, 7>> poses{keyframes};
  std::vector<double> lambdas;
  ceres::Problem problem;
  ceres::Solver::Options options;
  ceres::Solver::Summary summary;

  explicit CeresWindow(const Window<double>& w) : window(w), lambdas(w.landmarks().size()) {
    restart();
    for (Vec<double, 7>& pose : poses) problem.AddParameterBlock(pose.data(), 7, new PoseManifold);
    problem.AddResidualBlock(new FirstPoseCost(window.backend.window()[0].pose.value()), nullptr, poses[0].data());
    options.linear_solver_ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    for (std::size_t i = 0; i < lambdas.size(); ++i) add(window.landmarks()[i], &lambdas[i]);
    for (Vec<double, 7>& pose : poses) options.linear_solver_ordering->AddElementToGroup(pose.data(), 1);
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.logging_type = ceres::SILENT;
  }
  void add(const Window<double>::Map::Landmark& landmark, double* lambda) {
    options.linear_solver_ordering->AddElementToGroup(lambda, 0);
    for (int slot = 0; slot < keyframes; ++slot) {
      const PointObservation<double>& seen = landmark.observations[std::size_t(slot)];
      if (!seen.valid) continue;
      if (slot == landmark.anchor) {
        problem.AddResidualBlock(new AnchorDepthCost(landmark.bearing.z(), seen.depth), new ceres::HuberLoss(1.345),
                                 lambda);
        continue;
      }
      double *const anchor = poses[std::size_t(landmark.anchor)].data(), *const target =
                                                                             poses[std::size_t(slot)].data();
      problem.AddResidualBlock(new PixelCost(window.rig.vision.camera, landmark.bearing, seen),
                               new ceres::HuberLoss(2.45), anchor, target, lambda);
      problem.AddResidualBlock(new DepthCost(landmark.bearing, seen.depth), new ceres::HuberLoss(1.345), anchor, target,
                               lambda);
    }
  }
  void restart() { read(window); }
  /// The state of one of ours.
  template <class S>
  void read(const Window<S>& w) {
    for (int k = 0; k < keyframes; ++k) {
      PoseManifold::write(w.backend.window()[k].pose.value().template cast<double>(), poses[std::size_t(k)].data());
    }
    for (std::size_t i = 0; i < lambdas.size(); ++i) lambdas[i] = double(w.landmarks()[i].inverse_range);
  }
  double cost() {
    double out = 0;
    problem.Evaluate({}, &out, nullptr, nullptr, nullptr);
    return out;
  }
  int iterations() const { return summary.num_successful_steps + summary.num_unsuccessful_steps; }
  void solve() { ceres::Solve(options, &problem, &summary); }
};

void window_solve_ceres(benchmark::State& state) {
  const auto window = std::make_unique<Window<double>>();
  CeresWindow with_ceres(*window);
  for (auto _ : state) {
    with_ceres.restart();
    const double begin = seconds();
    with_ceres.solve();
    state.SetIterationTime(seconds() - begin);
  }
  state.counters["iterations"] = with_ceres.iterations();
}
BENCHMARK(window_solve_ceres)->Unit(benchmark::kMillisecond)->UseManualTime();

double relative(double a, double b) { return std::abs(a - b) / b; }

/// Ours and Ceres start from the same cost and end at the same one, or their times mean nothing.
template <class S>
bool agrees_with_ceres(const char* name) {
  const auto ours = std::make_unique<Window<S>>();
  const auto reference = std::make_unique<Window<double>>();
  CeresWindow with_ceres(*reference);
  const double start = with_ceres.cost();
  with_ceres.solve();
  const double expected = with_ceres.cost();
  const LevenbergMarquardtSummary summary = ours->backend.optimize(ours->rig, ours->maps);
  with_ceres.read(*ours);
  const double found = with_ceres.cost();
  std::printf("%-22s cost %.9g -> %.9g in %d iterations, Ceres %.9g -> %.9g in %d\n", name, summary.initial_cost, found,
              summary.iterations, start, expected, with_ceres.iterations());
  return relative(summary.initial_cost, start) < cost_agreement && relative(found, expected) < cost_agreement;
}

/// The times of both, to be compared.
class Comparison : public benchmark::ConsoleReporter {
 public:
  void ReportRuns(const std::vector<Run>& runs) override {
    ConsoleReporter::ReportRuns(runs);
    for (const Run& run : runs) {
      if (run.run_type != Run::RT_Iteration) continue;
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

#endif

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  benchmark::Initialize(&argc, argv);
#ifdef PLUMBLINE_CERES
  using namespace plumbline;
  const bool float_agrees = agrees_with_ceres<float>("window_solve<float>"),
             double_agrees = agrees_with_ceres<double>("window_solve<double>");
  if (!float_agrees || !double_agrees) {
    std::fprintf(stderr, "the costs differ\n");
    return 1;
  }
  Comparison comparison;
  benchmark::RunSpecifiedBenchmarks(&comparison);
#else
  benchmark::RunSpecifiedBenchmarks();
#endif
}
