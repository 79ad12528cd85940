// The local bundle adjustment against Ceres, whose residuals are written apart and differentiated automatically.
#include "plumbline/map/local_bundle_adjustment.hpp"

#include <ceres/ceres.h>

#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/testing/simulated_bundle.hpp"

using namespace plumbline;
using testing::SimulatedBundle;
using testing::SimulatedBundleOptions;

namespace {

using Solver = LocalBundleAdjustment<double, 10, 150, 1500, 20, 1>;
constexpr double chi2_two_rows = 5.991, chi2_range = 3.841;

template <class T>
Vec<T, 3> in_camera(const T* q, const T* c, const Vec<T, 3>& p) {
  return Eigen::Map<const Eigen::Quaternion<T>>(q).conjugate() * Vec<T, 3>(p - Eigen::Map<const Vec<T, 3>>(c));
}
template <class T>
Vec<T, 3> vector(const T* x) {
  return {x[0], x[1], x[2]};
}

/// The components of the ray across the bearing, by that along it.
struct BearingCost {
  Vec<double, 3> b;
  double sigma;
  template <class T>
  bool operator()(const T* q, const T* c, const T* X, T* out) const {
    const Vec<T, 3> p = in_camera(q, c, vector(X));
    const Vec<double, 3> u = b.unitOrthogonal(), v = b.cross(u);
    const T along = p.dot(b.cast<T>());
    out[0] = p.dot(u.cast<T>()) / along / sigma;
    out[1] = p.dot(v.cast<T>()) / along / sigma;
    return true;
  }
};
struct RangeCost {
  Vec<double, 3> b;
  double range, sigma;
  template <class T>
  bool operator()(const T* q, const T* c, const T* X, T* out) const {
    out[0] = (T(1) / in_camera(q, c, vector(X)).dot(b.cast<T>()) - 1 / range) * (range * range / sigma);
    return true;
  }
};

/// A line moves across itself and turns: four numbers in the axes of its start.
struct LineChart {
  Vec<double, 3> p, v;
  template <class T>
  void at(const T* x, Vec<T, 3>& point, Vec<T, 3>& direction) const {
    const Vec<double, 3> e = v.unitOrthogonal(), f = v.cross(e);
    point = p.cast<T>() + e.cast<T>() * x[0] + f.cast<T>() * x[1];
    direction = (v.cast<T>() + e.cast<T>() * x[2] + f.cast<T>() * x[3]).normalized();
  }
};
struct SegmentCost {
  LineChart line;
  Vec<double, 3> a, b;
  double sigma;
  template <class T>
  bool operator()(const T* q, const T* c, const T* x, T* out) const {
    Vec<T, 3> p, v;
    line.at(x, p, v);
    const Vec<T, 3> n = in_camera(q, c, p).cross(in_camera(q, c, Vec<T, 3>(p + v))).normalized();
    out[0] = n.dot(a.cast<T>()) / sigma;
    out[1] = n.dot(b.cast<T>()) / sigma;
    return true;
  }
};
/// Three rows whose length is the distance by the range.
struct MemberCost {
  LineChart line;
  double sigma;
  template <class T>
  bool operator()(const T* c, const T* X, const T* x, T* out) const {
    Vec<T, 3> p, v;
    line.at(x, p, v);
    const Vec<T, 3> point = vector(X), across = Vec<T, 3>(point - p).cross(v);
    Eigen::Map<Vec<T, 3>> whitened(out);
    whitened = across / ((point - vector(c)).norm() * sigma);
    return true;
  }
};

struct Minimum {
  double cost;
  std::vector<SE3<double>> poses;
  std::vector<Vec<double, 3>> points, line_points, line_directions;
};

Minimum solve_with_ceres(const SimulatedBundle& world) {
  const double sigma = world.options.sigma_rad;
  std::vector<Vec<double, 4>> q, x(world.lines.size(), zeros<double, 4>());
  std::vector<Vec<double, 3>> c, X;
  std::vector<LineChart> charts;
  for (const auto& k : world.keyframes) {
    q.push_back(k.start.rotation().quaternion().coeffs());
    c.push_back(k.start.p());
  }
  for (const auto& p : world.points) X.push_back(p.start);
  for (const auto& l : world.lines) charts.push_back({l.start_point, l.start_direction});

  ceres::Problem problem;
  for (std::size_t k = 0; k < q.size(); ++k) {
    problem.AddParameterBlock(q[k].data(), 4, new ceres::EigenQuaternionManifold);
    problem.AddParameterBlock(c[k].data(), 3);
    if (!world.keyframes[k].is_fixed) continue;
    problem.SetParameterBlockConstant(q[k].data());
    problem.SetParameterBlockConstant(c[k].data());
  }
  const auto two_rows = [] { return new ceres::HuberLoss(std::sqrt(chi2_two_rows)); };
  std::vector<int> first(X.size(), -1);
  for (const auto& o : world.observations) {
    const std::size_t k = std::size_t(o.keyframe), p = std::size_t(o.point);
    if (first[p] < 0) first[p] = o.keyframe;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<BearingCost, 2, 4, 3, 3>(new BearingCost{o.bearing, sigma}), two_rows(),
        q[k].data(), c[k].data(), X[p].data());
    if (!(o.range > 0)) continue;
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<RangeCost, 1, 4, 3, 3>(new RangeCost{o.bearing, o.range, o.sigma_range}),
        new ceres::HuberLoss(std::sqrt(chi2_range)), q[k].data(), c[k].data(), X[p].data());
  }
  for (const auto& s : world.segments) {
    const std::size_t k = std::size_t(s.keyframe), l = std::size_t(s.line);
    auto* cost = new SegmentCost{charts[l], s.bearing_a, s.bearing_b, sigma};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<SegmentCost, 2, 4, 3, 4>(cost), two_rows(), q[k].data(),
                             c[k].data(), x[l].data());
  }
  for (const auto& m : world.members) {
    const std::size_t p = std::size_t(m.point), l = std::size_t(m.line);
    auto* cost = new MemberCost{charts[l], SimulatedBundle::sigma_member};
    problem.AddResidualBlock(new ceres::AutoDiffCostFunction<MemberCost, 3, 3, 3, 4>(cost), two_rows(),
                             c[std::size_t(first[p])].data(), X[p].data(), x[l].data());
  }
  ceres::Solver::Options options;
  options.max_num_iterations = 500;
  options.function_tolerance = 1e-15;
  options.gradient_tolerance = 1e-12;
  options.parameter_tolerance = 1e-14;
  options.linear_solver_type = ceres::DENSE_SCHUR;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  Minimum out{summary.final_cost, {}, X, {}, {}};
  for (std::size_t k = 0; k < q.size(); ++k) out.poses.emplace_back(SO3<double>(Eigen::Quaterniond(q[k])), c[k]);
  for (std::size_t l = 0; l < x.size(); ++l) {
    Vec<double, 3> p, v;
    charts[l].at(x[l].data(), p, v);
    out.line_points.push_back(p);
    out.line_directions.push_back(v);
  }
  return out;
}

void require_same_minimum(const SimulatedBundle& world) {
  LocalBundleAdjustmentOptions options;
  options.chi2_two_rows = chi2_two_rows;
  options.chi2_range = chi2_range;
  options.levenberg_marquardt.max_iterations = 1000;
  options.levenberg_marquardt.relative_cost_tolerance = 1e-15;
  const auto solver = std::make_unique<Solver>(options);
  REQUIRE(world.fill<double>(*solver));
  solver->begin();
  while (!solver->iterate(1000)) {
  }
  const Minimum expected = solve_with_ceres(world);
  REQUIRE(solver->initial_cost() > 3 * expected.cost);
  REQUIRE(solver->cost() < (1 + 1e-7) * expected.cost);
  REQUIRE(solver->cost() > (1 - 1e-4) * expected.cost);  // with robust losses Ceres may stop above it
  for (std::size_t k = 0; k < expected.poses.size(); ++k) {
    REQUIRE(minus(solver->pose(int(k)), expected.poses[k]).norm() < 1e-4);
  }
  std::vector<int> observed(world.points.size());
  for (const auto& o : world.observations) ++observed[std::size_t(o.point)];
  for (std::size_t p = 0; p < observed.size(); ++p) {
    if (observed[p] >= 3) REQUIRE((solver->point(int(p)) - expected.points[p]).norm() < 1e-3);
  }
  std::vector<int> segments(world.lines.size());
  for (const auto& s : world.segments) ++segments[std::size_t(s.line)];
  for (std::size_t l = 0; l < world.lines.size(); ++l) {
    if (segments[l] < 2) continue;
    REQUIRE(solver->line_direction(int(l)).cross(expected.line_directions[l]).norm() < 1e-4);
    REQUIRE((solver->line_point(int(l)) - expected.line_points[l]).cross(expected.line_directions[l]).norm() < 1e-3);
  }
}

}  // namespace

TEST_CASE("local_bundle_adjustment: same minimum as Ceres, points") {
  for (const double ranges : {0.0, 0.5}) {
    for (const double outliers : {0.0, 0.03}) {
      SimulatedBundleOptions options;
      options.range_share = ranges;
      options.outlier_share = outliers;
      require_same_minimum(SimulatedBundle(options));
    }
  }
}

TEST_CASE("local_bundle_adjustment: same minimum as Ceres, lines and points on them") {
  SimulatedBundleOptions options;
  options.lines = 15;
  const SimulatedBundle world(options);
  REQUIRE(world.segments.size() > 30);
  REQUIRE(world.members.size() > 40);
  require_same_minimum(world);
  SimulatedBundle apart = world;  // segments alone
  apart.members.clear();
  require_same_minimum(apart);
  options.range_share = 0.3;
  options.outlier_share = 0.02;
  options.seed = 5;
  require_same_minimum(SimulatedBundle(options));
}
