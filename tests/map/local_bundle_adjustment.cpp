#include "plumbline/map/local_bundle_adjustment.hpp"

#include <limits>
#include <memory>

#include "catch.hpp"
#include "map/simulated_graph.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "plumbline/testing/simulated_bundle.hpp"

using namespace plumbline;
using testing::SimulatedBundle;
using testing::SimulatedBundleOptions;

namespace {

template <class S>
using Solver = LocalBundleAdjustment<S, 12, 400, 4000, 30, 12>;

LocalBundleAdjustmentOptions thorough() {
  LocalBundleAdjustmentOptions options;
  options.levenberg_marquardt.max_iterations = 100;
  options.levenberg_marquardt.relative_cost_tolerance = 1e-12;
  return options;
}

template <class S>
std::unique_ptr<Solver<S>> prepare(const SimulatedBundle& world,
                                   const LocalBundleAdjustmentOptions& options = thorough()) {
  auto solver = std::make_unique<Solver<S>>(options);
  REQUIRE(world.fill<S>(*solver));
  solver->begin();
  return solver;
}
template <class S>
std::unique_ptr<Solver<S>> solve(const SimulatedBundle& world,
                                 const LocalBundleAdjustmentOptions& options = thorough()) {
  auto solver = prepare<S>(world, options);
  while (!solver->iterate(100000)) {
  }
  return solver;
}

template <class S>
double pose_error(const SimulatedBundle& world, const Solver<S>& solver, int k) {
  return minus(solver.pose(k).template cast<double>(), world.keyframes[std::size_t(k)].truth).norm();
}
template <class S>
double point_error(const SimulatedBundle& world, const Solver<S>& solver, int p) {
  return (cast_to<double>(solver.point(p)) - world.points[std::size_t(p)].truth).norm();
}
/// Root mean squares over all poses, and over all points that three keyframes or more observe.
template <class S>
std::pair<double, double> errors(const SimulatedBundle& world, const Solver<S>& solver) {
  double poses = 0, points = 0;
  int count = 0;
  const int n = int(world.keyframes.size());
  for (int k = 0; k < n; ++k) poses += std::pow(pose_error(world, solver, k), 2) / n;
  std::vector<int> observed(world.points.size());
  for (const auto& o : world.observations) ++observed[std::size_t(o.point)];
  for (std::size_t p = 0; p < observed.size(); ++p) {
    if (observed[p] < 3) continue;
    points += std::pow(point_error(world, solver, int(p)), 2);
    ++count;
  }
  return {std::sqrt(poses), std::sqrt(points / count)};
}

/// Distance of the middle of the true line from the estimated one, and the angle between them.
template <class S>
std::pair<double, double> line_errors(const SimulatedBundle& world, const Solver<S>& solver, int l) {
  const auto& truth = world.lines[std::size_t(l)];
  const Vec<double, 3> v = cast_to<double>(solver.line_direction(l)), p = cast_to<double>(solver.line_point(l));
  return {(truth.truth_point - p).cross(v).norm(), truth.truth_direction.cross(v).norm()};
}

/// Everything that is estimated.
template <class S>
std::vector<S> state(const SimulatedBundle& world, const Solver<S>& solver) {
  std::vector<S> out;
  for (std::size_t k = 0; k < world.keyframes.size(); ++k) {
    for (const S number : test::numbers(solver.pose(int(k)))) out.push_back(number);
  }
  for (std::size_t p = 0; p < world.points.size(); ++p) {
    for (int n = 0; n < 3; ++n) out.push_back(solver.point(int(p))[n]);
  }
  for (std::size_t l = 0; l < world.lines.size(); ++l) {
    for (int n = 0; n < 3; ++n) out.push_back(solver.line_point(int(l))[n]);
    for (int n = 0; n < 3; ++n) out.push_back(solver.line_direction(int(l))[n]);
  }
  return out;
}

}  // namespace

TEMPLATE_TEST_CASE("local_bundle_adjustment: exact measurements give the truth", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-9;
  for (const bool ranges : {false, true}) {
    SimulatedBundleOptions options;
    options.noise = 0;
    options.range_share = ranges ? 0.5 : 0;
    options.edges = ranges;
    options.fixed = ranges ? 1 : 2;
    options.lines = ranges ? 10 : 0;
    const SimulatedBundle world(options);
    const auto solver = solve<S>(world);
    REQUIRE(solver->initial_cost() > 1000);
    REQUIRE(solver->cost() < (std::is_same_v<S, float> ? 1e-3 : 1e-12));
    const auto [poses, points] = errors(world, *solver);
    CHECK(poses < tolerance);
    CHECK(points < 10 * tolerance);
    for (std::size_t o = 0; o < world.observations.size(); ++o) REQUIRE(solver->is_inlier(int(o)));
    int observed = 0;
    for (int l = 0; l < options.lines; ++l) {
      int segments = 0;
      for (const auto& segment : world.segments) segments += segment.line == l;
      if (segments < 3) continue;
      ++observed;
      CHECK(line_errors(world, *solver, l).first < 20 * tolerance);
      CHECK(line_errors(world, *solver, l).second < 20 * tolerance);
    }
    CHECK(observed >= options.lines / 2);
  }
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: noise leaves what it must", "", float, double) {
  using S = TestType;
  double cost = 0, start = 0, end = 0;
  constexpr int runs = 10;
  int dof = 0;
  auto options = thorough();
  options.chi2_two_rows = options.chi2_range = 1e6;  // least squares
  for (int run = 0; run < runs; ++run) {
    SimulatedBundleOptions world_options;
    world_options.range_share = 0.3;
    world_options.edges = true;
    world_options.seed = std::uint64_t(run + 1);
    const SimulatedBundle world(world_options);
    const auto solver = solve<S>(world, options);
    std::vector<bool> observed(world.points.size());
    int rows = 6 * int(world.edges.size()) - 6;  // the edge between the two fixed ones has no unknown
    for (const auto& o : world.observations) {
      rows += o.range > 0 ? 3 : 2;
      observed[std::size_t(o.point)] = true;
    }
    dof = 0;
    for (const bool is_observed : observed) dof += is_observed ? 3 : 0;
    dof = rows - dof - 6 * (world_options.keyframes - world_options.fixed);
    const auto initial = errors(world, *prepare<S>(world)), found = errors(world, *solver);
    start += initial.first / runs;
    end += found.first / runs;
    CHECK(found.second < 0.5 * initial.second);
    cost += 2 * double(solver->cost()) / dof / runs;
  }
  // 2 cost is chi-square of `dof` degrees of freedom; points with one observation alone fit it: a few rows less.
  CHECK(std::abs(cost - 1) < 0.08);
  CHECK(end < 0.2 * start);
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: 10 % of the bearings are wrong", "", float, double) {
  using S = TestType;
  SimulatedBundleOptions options;
  options.outlier_share = 0.1;
  const SimulatedBundle world(options);
  options.outlier_share = 0;
  const SimulatedBundle clean(options);
  const auto solver = solve<S>(world), without = solve<S>(clean);
  CHECK(errors(world, *solver).first < 0.005 + 2 * errors(clean, *without).first);
  int wrong = 0, outliers = 0, inliers = 0, kept = 0;
  for (std::size_t o = 0; o < world.observations.size(); ++o) {
    if (world.observations[o].is_outlier) {
      ++outliers;
      wrong += solver->is_inlier(int(o));
    } else {
      ++inliers;
      kept += solver->is_inlier(int(o));
    }
  }
  REQUIRE(outliers > 30);
  CHECK(wrong < 0.1 * outliers);  // along the epipolar line, or of a point that nothing else observed
  CHECK(kept > 0.8 * inliers);
  // Least squares is bent by them.
  auto least_squares = thorough();
  least_squares.chi2_two_rows = 1e9;
  CHECK(errors(world, *solve<S>(world, least_squares)).first > 3 * errors(world, *solver).first);
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: slices give the same bits as one call", "", float, double) {
  using S = TestType;
  SimulatedBundleOptions options;
  options.edges = true;
  options.range_share = 0.2;
  options.outlier_share = 0.02;
  options.lines = 12;
  const SimulatedBundle world(options);
  const auto at_once = solve<S>(world);
  for (const int budget : {1, 37, 1000}) {
    auto solver = prepare<S>(world);
    int slices = 1;
    while (!solver->iterate(budget)) ++slices;
    REQUIRE(slices > 3);
    REQUIRE(state(world, *solver) == state(world, *at_once));
    REQUIRE(solver->cost() == at_once->cost());
    REQUIRE(solver->summary().iterations == at_once->summary().iterations);
  }
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: a fixed keyframe never moves", "", float, double) {
  using S = TestType;
  const SimulatedBundle world;
  const auto solver = solve<S>(world);
  for (int k = 0; k < 8; ++k) {
    const bool moved =
        test::numbers(solver->pose(k)) != test::numbers(world.keyframes[std::size_t(k)].start.template cast<S>());
    CHECK(moved == (k >= 2));
  }
  SimulatedBundleOptions options;  // all of them: points alone
  options.fixed = 8;
  options.noise = 0;
  const SimulatedBundle structure(options);
  const auto points = solve<S>(structure);
  CHECK(points->cost() < 1e-3);
  CHECK(points->cost() < 1e-3 * points->initial_cost());
  CHECK((points->has_converged() || std::is_same_v<S, float>));  // float ends at its rounding
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: without anything that fixes scale or position it stays solvable", "",
                   float, double) {
  using S = TestType;
  for (const int fixed : {0, 1}) {
    SimulatedBundleOptions options;
    options.fixed = fixed;
    const SimulatedBundle world(options);
    const auto solver = solve<S>(world);
    CHECK(solver->cost() < 0.2 * solver->initial_cost());
    CHECK(solver->cost() < 1.02 * solve<S>(SimulatedBundle{})->cost());
    for (int k = 0; k < 8; ++k) CHECK(pose_error(world, *solver, k) < 0.5);
  }
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: degenerate points change nothing else", "", float, double) {
  using S = TestType;
  SimulatedBundleOptions options;
  options.noise = 0;
  const SimulatedBundle world(options);
  auto solver = std::make_unique<Solver<S>>(thorough());
  REQUIRE(world.fill<S>(*solver));
  const SE3<double>& T = world.keyframes[3].truth;
  const Vec<S, 3> ahead(S(0), S(0), S(1));
  const int behind = solver->add_point(cast_to<S>(T * Vec<double, 3>(0, 0, -2)));
  const int observation = solver->add_observation(3, behind, ahead, S(1e-3));
  const int once = solver->add_point(cast_to<S>(T * Vec<double, 3>(0.2, 0, 4)));
  const int bearing = solver->add_observation(3, once, ahead, S(1e-3));
  const int never = solver->add_point(Vec<S, 3>(S(1), S(2), S(3)));
  const int far = solver->add_point(cast_to<S>(T * Vec<double, 3>(0, 0, 1e4)));
  for (const int k : {3, 4}) {
    const Vec<double, 3> p_cam = world.keyframes[std::size_t(k)].truth.inverse() * (T * Vec<double, 3>(0, 0, 1e4));
    REQUIRE(solver->add_observation(k, far, cast_to<S>(p_cam.normalized().eval()), S(1e-3)) >= 0);
  }
  REQUIRE(observation >= 0);
  solver->begin();
  while (!solver->iterate(1000)) {
  }
  CHECK(errors(world, *solver).first < (std::is_same_v<S, float> ? 1e-3 : 1e-8));
  CHECK(!solver->is_inlier(observation));
  CHECK(solver->is_inlier(bearing));
  CHECK(solver->point(behind) == cast_to<S>(T * Vec<double, 3>(0, 0, -2)));
  CHECK(solver->point(never) == Vec<S, 3>(S(1), S(2), S(3)));
  CHECK((T.cast<S>().inverse() * solver->point(once)).z() > S(1));
  CHECK(all_finite(solver->point(far)));
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: bad input is refused", "", float, double) {
  using S = TestType;
  LocalBundleAdjustment<S, 2, 1, 2, 1, 1> solver;
  const S nan = std::numeric_limits<S>::quiet_NaN(), inf = std::numeric_limits<S>::infinity();
  const Vec<S, 3> b(S(0), S(0), S(1)), bad(S(0), nan, S(1)), p(S(0), S(0), S(4));
  Mat<S, 6, 6> Q = Mat<S, 6, 6>::Identity();
  solver.begin();  // empty
  CHECK(solver.iterate(100));
  CHECK(solver.add_observation(0, 0, b, S(1)) == -1);
  CHECK(solver.add_keyframe(SE3<S>(SO3<S>(), bad), false) == -1);
  CHECK(solver.add_keyframe({}, true) == 0);
  CHECK(solver.add_keyframe({}, false) == 1);
  CHECK(solver.add_keyframe({}, false) == -1);
  CHECK(solver.add_point(bad) == -1);
  CHECK(solver.add_point(p) == 0);
  CHECK(solver.add_point(p) == -1);
  for (const S sigma : {S(0), S(-1), nan, S(1e-40)}) {
    if (sigma > S(0) && !std::is_same_v<S, float>) continue;
    CHECK(solver.add_observation(0, 0, b, sigma) == -1);
  }
  CHECK(solver.add_observation(2, 0, b, S(1)) == -1);
  CHECK(solver.add_observation(-1, 0, b, S(1)) == -1);
  CHECK(solver.add_observation(0, 1, b, S(1)) == -1);
  CHECK(solver.add_observation(0, 0, bad, S(1)) == -1);
  CHECK(solver.add_observation(0, 0, Vec<S, 3>(2 * b), S(1)) == -1);
  for (const S range : {S(-1), nan, inf}) CHECK(solver.add_observation(0, 0, b, S(1), range, S(1)) == -1);
  for (const S sigma : {S(0), S(-1), nan}) CHECK(solver.add_observation(0, 0, b, S(1), S(4), sigma) == -1);
  CHECK(solver.add_observation(0, 0, b, S(0.1)) == 0);
  CHECK(solver.add_observation(1, 0, b, S(0.1), S(4), S(0.1)) == 1);
  CHECK(solver.add_observation(1, 0, b, S(0.1)) == -1);
  CHECK(!solver.add_edge(0, 2, {}, Q));
  CHECK(!solver.add_edge(1, 1, {}, Q));
  CHECK(!solver.add_edge(0, 1, SE3<S>(SO3<S>(), bad), Q));
  CHECK(!solver.add_edge(0, 1, {}, Mat<S, 6, 6>(-Q)));
  CHECK(solver.add_edge(0, 1, {}, Q));
  CHECK(!solver.add_edge(0, 1, {}, Q));
  solver.begin();
  CHECK(solver.initial_cost() == S(0));
  CHECK(solver.iterate(1000));
  CHECK(solver.has_converged());
  solver.clear();
  CHECK(solver.add_keyframe({}, true) == 0);
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: points on lines are more accurate", "", float, double) {
  using S = TestType;
  double with = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    SimulatedBundleOptions options;
    options.lines = 15;
    options.points = 150;
    options.sigma_rad = 4e-3;
    options.seed = seed;
    SimulatedBundle world(options), apart(options);
    apart.lines.clear();
    apart.members.clear();
    apart.segments.clear();
    const auto solver = solve<S>(world), points = solve<S>(apart);
    CHECK(solver->cost() > S(0));
    for (const auto& member : world.members) {
      int observed = 0;
      for (const auto& o : world.observations) observed += o.point == member.point;
      if (observed < 4) continue;
      with += std::pow(point_error(world, *solver, member.point), 2);
      without += std::pow(point_error(apart, *points, member.point), 2);
    }
  }
  CHECK(with < 0.8 * without);
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: lines without segments, points or both", "", float, double) {
  using S = TestType;
  SimulatedBundleOptions options;
  options.lines = 10;
  options.noise = 0;
  SimulatedBundle members_alone(options), segments_alone(options), neither(options);
  members_alone.segments.clear();
  segments_alone.members.clear();
  neither.members.clear();
  neither.segments.clear();
  for (const SimulatedBundle* world : {&members_alone, &segments_alone, &neither}) {
    const auto solver = solve<S>(*world);
    CHECK(errors(*world, *solver).first < (std::is_same_v<S, float> ? 1e-4 : 1e-8));
    for (int l = 0; l < options.lines; ++l) CHECK(all_finite(solver->line_point(l)));
  }
  const auto untouched = solve<S>(neither);
  const Vec<S, 3> p = cast_to<S>(neither.lines[3].start_point), v = cast_to<S>(neither.lines[3].start_direction);
  CHECK((p - untouched->line_point(3)).cross(v).norm() < S(1e-5));
  CHECK((untouched->line_direction(3) - v).norm() < S(1e-5));
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: lines that leave the view do not hold up the others", "", float, double) {
  using S = TestType;
  int quick = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {  // with lines along the baseline of those that observe them
    SimulatedBundleOptions options;
    options.keyframes = 20;
    options.fixed = 10;
    options.points = 650;
    options.lines = 150;
    options.start_angle = 0.003;
    options.start_position = 0.01;
    options.start_point = 0.03;
    options.seed = seed;
    SimulatedBundle world(options);
    world.members.clear();
    const auto cost_after = [&](int iterations) {
      LocalBundleAdjustmentOptions solver_options;
      solver_options.levenberg_marquardt.max_iterations = iterations;
      const auto solver = std::make_unique<LocalBundleAdjustment<S, 20, 700, 9000, 150, 1>>(solver_options);
      REQUIRE(world.fill<S>(*solver));
      solver->begin();
      while (!solver->iterate(1000)) {
      }
      CHECK(solver->cost() < S(0.1) * solver->initial_cost());
      return solver->cost();
    };
    quick += cost_after(8) < S(1.01) * cost_after(60);
  }
  CHECK(quick >= 4);  // of 24 worlds one goes along a valley for 34 iterations
}

TEMPLATE_TEST_CASE("local_bundle_adjustment: bad lines are refused", "", float, double) {
  using S = TestType;
  LocalBundleAdjustment<S, 1, 2, 4, 1, 0> solver;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  const Vec<S, 3> a(S(0), S(0), S(1)), b(S(0.6), S(0), S(0.8)), p(S(0), S(0), S(4)), zero = zeros<S, 3>();
  REQUIRE(solver.add_keyframe({}, false) == 0);
  REQUIRE(solver.add_point(p) == 0);
  REQUIRE(solver.add_point(p) == 1);
  CHECK(solver.add_line(p, zero) == -1);
  CHECK(solver.add_line(Vec<S, 3>(nan, S(0), S(0)), a) == -1);
  CHECK(!solver.add_to_line(0, 0, S(1)));
  CHECK(solver.add_line_observation(0, 0, a, b, S(1)) == -1);
  CHECK(solver.add_line(p, b) == 0);
  CHECK(solver.add_line(p, b) == -1);
  CHECK(!solver.add_to_line(0, 0, S(1)));  // no observation
  REQUIRE(solver.add_observation(0, 0, a, S(0.1)) == 0);
  CHECK(!solver.add_to_line(1, 0, S(1)));
  CHECK(!solver.add_to_line(0, 2, S(1)));
  CHECK(!solver.add_to_line(0, -1, S(1)));
  for (const S sigma : {S(0), S(-1), nan}) {
    CHECK(!solver.add_to_line(0, 0, sigma));
    CHECK(solver.add_line_observation(0, 0, a, b, sigma) == -1);
  }
  CHECK(solver.add_to_line(0, 0, S(1)));
  CHECK(!solver.add_to_line(0, 0, S(1)));  // on one already
  CHECK(solver.add_line_observation(1, 0, a, b, S(1)) == -1);
  CHECK(solver.add_line_observation(0, 0, a, a, S(1)) == -1);
  CHECK(solver.add_line_observation(0, 0, a, Vec<S, 3>(2 * b), S(1)) == -1);
  CHECK(solver.add_line_observation(0, 0, a, b, S(1)) == 0);
  CHECK(solver.add_line_observation(0, 0, a, b, S(1)) == -1);  // one for each keyframe
  solver.begin();
  while (!solver.iterate(10)) {
  }
  CHECK(solver.cost() <= solver.initial_cost());
  LocalBundleAdjustment<S, 1, 1, 1, 0, 0> without;
  CHECK(without.add_line(p, b) == -1);
}
