// A local bundle adjustment: 20 keyframes, 10 of them free, 2,000 points, 150 lines with four of the points each; every
// point seen by all keyframes whose view contains it, 1 % of the bearings wrong. Ceres solves the same problem
// (residuals, kernels, start, tolerance; the library's analytic Jacobians, SPARSE_SCHUR, one thread); the program fails
// unless both reach the same cost.
#include "plumbline/map/local_bundle_adjustment.hpp"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <vector>

#include "../backend/ceres_window.hpp"
#include "plumbline/testing/simulated_bundle.hpp"

namespace plumbline {
namespace {

using namespace bench;

const testing::SimulatedBundle& world() {
  static const testing::SimulatedBundle out([] {
    testing::SimulatedBundleOptions options;
    options.keyframes = 20;
    options.fixed = 10;
    options.points = 2000;
    options.lines = 150;
    options.outlier_share = 0.01;
    options.start_angle = 0.003;
    options.start_position = 0.01;
    options.start_point = 0.03;
    return options;
  }());
  return out;
}

template <class S>
struct Bundle {
  using Solver = LocalBundleAdjustment<S, 20, 2000, 24000, 150, 1>;
  Solver solver;

  Bundle() {
    if (!world().fill<S>(solver)) std::abort();
  }
  LevenbergMarquardtSummary solve() {
    solver.begin();
    while (!solver.iterate(1000)) {
    }
    return solver.summary();
  }
};

/// The longest of the slices of 500 units, `begin` apart.
template <class S>
void longest_slice(benchmark::State& state) {
  const auto start = std::make_unique<Bundle<S>>(), bundle = std::make_unique<Bundle<S>>(*start);
  for (auto _ : state) {
    *bundle = *start;
    bundle->solver.begin();
    double longest = 0;
    for (bool done = false; !done;) {
      const double begin = seconds();
      done = bundle->solver.iterate(500);
      longest = std::max(longest, seconds() - begin);
    }
    state.SetIterationTime(longest);
  }
  state.counters["bytes"] = sizeof(Bundle<S>);
}

#ifdef PLUMBLINE_CERES

using Line = Eigen::Map<const Vec<double, 6>>;  // (n; v)

/// Moves by `plus` of Line3; derivatives by its four numbers stand in the first four columns.
class LineManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 6; }
  int TangentSize() const override { return 4; }
  bool Plus(const double* x, const double* d, double* out) const override {
    write(read(x).plus(Vec<double, 4>(Eigen::Map<const Vec<double, 4>>(d))), out);
    return true;
  }
  bool PlusJacobian(const double*, double* J) const override {
    Eigen::Map<Eigen::Matrix<double, 6, 4, Eigen::RowMajor>>(J).setIdentity();
    return true;
  }
  bool Minus(const double*, const double*, double*) const override { return false; }
  bool MinusJacobian(const double*, double*) const override { return false; }
  static Line3<double> read(const double* x) {
    return Line3<double>(Plucker<double>{Line(x).head<3>(), Line(x).tail<3>()});
  }
  static void write(const Line3<double>& line, double* x) {
    Eigen::Map<Vec<double, 6>>(x) << line.plucker().n, line.plucker().v;
  }
};

template <int Rows, int Cols, int Ambient = Cols>
void write_jacobian(const Mat<double, Rows, Cols>& J, double* out) {
  if (!out) return;
  Eigen::Map<Eigen::Matrix<double, Rows, Ambient, Ambient == 1 ? 0 : Eigen::RowMajor>> ambient(out);
  ambient.setZero();
  ambient.template leftCols<Cols>() = J;
}

struct BearingCost final : ceres::SizedCostFunction<2, 7, 3> {
  SE3<double> T_cam_bearing;
  double sigma;
  BearingCost(const Vec<double, 3>& bearing, double s)
      : T_cam_bearing(SO3<double>(Eigen::Quaterniond::FromTwoVectors(Vec<double, 3>::UnitZ(), bearing)),
                      zeros<double, 3>()),
        sigma(s) {}
  Vec<double, 2> behind() const { return {BearingObservation<double>::tangent_max / sigma, 0}; }  // as ours
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const BodyView<double> view(PoseManifold::read(x[0]), T_cam_bearing);
    const Vec<double, 3> X(x[1]);
    Eigen::Map<Vec<double, 2>> out(r);
    const Pinhole<double> camera{1, 1, 0, 0};
    if (!J) {
      const Projection<double> projection = camera.project(view.cam_point(X));
      out = projection.valid ? Vec<double, 2>(projection.uv / sigma) : behind();
      return true;
    }
    auto lin = PointReprojection<Pinhole<double>>{zeros<double, 2>()}.linearize(camera, view, X);
    if (!lin.valid) lin = {true, sigma * behind(), zeros<double, 2, 6>(), zeros<double, 2, 3>()};
    out = lin.r / sigma;
    write_pose_jacobian<2>(lin.J_r_pose / sigma, J[0]);
    write_jacobian<2, 3>(lin.J_r_point / sigma, J[1]);
    return true;
  }
};

struct SegmentCost final : ceres::SizedCostFunction<2, 7, 6> {
  WorldLine<LineReprojection<double>> seen;
  SegmentCost(const Vec<double, 3>& a, const Vec<double, 3>& b, double sigma) : seen{{a, b, {1 / sigma, 1 / sigma}}} {}
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const BodyView<double> view(PoseManifold::read(x[0]), SE3<double>());
    const Line3<double> line = LineManifold::read(x[1]);
    Eigen::Map<Vec<double, 2>> out(r);
    if (!J) {
      const Plucker<double> in_cam = line_in_camera(view, line.plucker());
      const LineReprojection<double>& measured = seen.measurement;
      const bool is_valid = line_visible<double>(in_cam, measured.bearing_start + measured.bearing_end);
      out = is_valid ? measured.residual(in_cam) : measured.px_per_rad;
      return true;
    }
    auto lin = seen.linearize(view, line.plucker());
    if (!lin.valid) lin = {true, seen.measurement.px_per_rad, zeros<double, 2, 6>(), zeros<double, 2, 6>()};
    out = lin.r;
    write_pose_jacobian<2>(lin.J_r_pose, J[0]);
    write_jacobian<2, 4, 6>(product(lin.J_r_line, line.plucker_jacobian()), J[1]);
    return true;
  }
};

struct MemberCost final : ceres::SizedCostFunction<2, 7, 3, 6> {
  static constexpr double sigma = testing::SimulatedBundle::sigma_member;
  bool Evaluate(const double* const* x, double* r, double** J) const override {
    const SE3<double> T = PoseManifold::read(x[0]);
    const Vec<double, 3> X(x[1]);
    const Line3<double> line = LineManifold::read(x[2]);
    Eigen::Map<Vec<double, 2>> out(r);
    if (!J) {
      out = CollinearWorldPoint<double>::residual(line, X, T.p()) / sigma;
      return true;
    }
    const auto lin = CollinearWorldPoint<double>::linearize(line, X, T.p());
    out = lin.r / sigma;
    Mat<double, 2, 6> J_pose = zeros<double, 2, 6>();
    J_pose.rightCols<3>() = lin.J_r_center * T.R() / sigma;
    write_pose_jacobian<2>(J_pose, J[0]);
    write_jacobian<2, 3>(lin.J_r_point / sigma, J[1]);
    write_jacobian<2, 4, 6>(lin.J_r_line / sigma, J[2]);
    return lin.valid;
  }
};

struct CeresBundle : CeresProblem {
  std::vector<Vec<double, 7>> poses;
  std::vector<Vec<double, 3>> points;
  std::vector<Vec<double, 6>> lines;

  CeresBundle() : poses(world().keyframes.size()), points(world().points.size()), lines(world().lines.size()) {
    restart();
    const LocalBundleAdjustmentOptions ours;
    const auto loss = [&] { return new ceres::HuberLoss(std::sqrt(ours.chi2_two_rows)); };
    for (std::size_t k = 0; k < poses.size(); ++k) {
      problem.AddParameterBlock(poses[k].data(), 7, new PoseManifold);
      if (world().keyframes[k].is_fixed) problem.SetParameterBlockConstant(poses[k].data());
    }
    for (Vec<double, 6>& line : lines) problem.AddParameterBlock(line.data(), 6, new LineManifold);
    std::vector<double*> first(points.size(), nullptr);
    for (const auto& o : world().observations) {
      double *const pose = poses[std::size_t(o.keyframe)].data(), *const point = points[std::size_t(o.point)].data();
      if (!first[std::size_t(o.point)]) first[std::size_t(o.point)] = pose;
      problem.AddResidualBlock(new BearingCost(o.bearing, world().options.sigma_rad), loss(), pose, point);
      options.linear_solver_ordering->AddElementToGroup(point, 0);
    }
    for (const auto& s : world().segments) {
      problem.AddResidualBlock(new SegmentCost(s.bearing_a, s.bearing_b, world().options.sigma_rad), loss(),
                               poses[std::size_t(s.keyframe)].data(), lines[std::size_t(s.line)].data());
    }
    for (const auto& m : world().members) {
      double* const point = points[std::size_t(m.point)].data();
      problem.AddResidualBlock(new MemberCost, loss(), first[std::size_t(m.point)], point,
                               lines[std::size_t(m.line)].data());
    }
    for (Vec<double, 6>& line : lines) options.linear_solver_ordering->AddElementToGroup(line.data(), 1);
    for (Vec<double, 7>& pose : poses) options.linear_solver_ordering->AddElementToGroup(pose.data(), 1);
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.function_tolerance = ours.levenberg_marquardt.relative_cost_tolerance;
    options.max_num_iterations = ours.levenberg_marquardt.max_iterations;
  }
  void restart() {
    for (std::size_t k = 0; k < poses.size(); ++k) PoseManifold::write(world().keyframes[k].start, poses[k].data());
    for (std::size_t p = 0; p < points.size(); ++p) points[p] = world().points[p].start;
    for (std::size_t l = 0; l < lines.size(); ++l) {
      const auto& line = world().lines[l];
      LineManifold::write(Line3<double>::through(line.start_point, line.start_point + line.start_direction),
                          lines[l].data());
    }
  }
  /// The state of one of ours.
  template <class S>
  void read(const Bundle<S>& bundle) {
    for (std::size_t k = 0; k < poses.size(); ++k) {
      PoseManifold::write(bundle.solver.pose(int(k)).template cast<double>(), poses[k].data());
    }
    for (std::size_t p = 0; p < points.size(); ++p) points[p] = cast_to<double>(bundle.solver.point(int(p)));
    for (std::size_t l = 0; l < lines.size(); ++l) {
      const Vec<double, 3> at = cast_to<double>(bundle.solver.line_point(int(l)));
      const Vec<double, 3> v = cast_to<double>(bundle.solver.line_direction(int(l)));
      LineManifold::write(Line3<double>::through(at, at + v), lines[l].data());
    }
  }
};

#endif

}  // namespace
}  // namespace plumbline

int main(int argc, char** argv) {
  using namespace plumbline;
  benchmark::RegisterBenchmark("local_bundle_adjustment_longest_slice<float>", longest_slice<float>)
      ->Iterations(20)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
  benchmark::RegisterBenchmark("local_bundle_adjustment_longest_slice<double>", longest_slice<double>)
      ->Iterations(20)
      ->Unit(benchmark::kMillisecond)
      ->UseManualTime();
#ifdef PLUMBLINE_CERES
  return bench::compare<Bundle, CeresBundle>(argc, argv, "local_bundle_adjustment", 1e-3, 1e-3);
#else
  benchmark::Initialize(&argc, argv);
  bench::register_solves<Bundle>("local_bundle_adjustment");
  benchmark::RunSpecifiedBenchmarks();
#endif
}
