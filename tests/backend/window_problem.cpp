// A window as a solver sees it: the cost is the sum of its parts, a minimum is where the numeric gradient vanishes, and
// a step that is undone leaves no trace.                                                            docs/math/window.md
#include "plumbline/backend/window_problem.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>
#include <tuple>
#include <vector>

#include "catch.hpp"
#include "feature/residuals_of.hpp"
#include "feature/seen_collinear.hpp"
#include "plumbline/backend/rig_prior.hpp"
#include "plumbline/backend/window_equations.hpp"
#include "plumbline/backend/window_prior.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/landmark_ties.hpp"
#include "plumbline/feature/window_terms.hpp"
#include "plumbline/feature/window_views.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/solver/levenberg_marquardt.hpp"

using namespace plumbline;

namespace {

using VecX = Eigen::VectorXd;

/// A factor of one frame: a measured position in the world.
struct MeasuredPosition {
  static constexpr int slot = 2;
  Vec<double, 3> p_world = Vec<double, 3>::Zero();
  double sigma = 5e-3;

  Vec<double, 3> residual(const auto& window) const { return (window.T_world_body(slot).p() - p_world) / sigma; }
  double cost(const auto& window) const { return residual(window).squaredNorm() / 2; }
  void for_each_row(const auto& window, int of, auto&& take) const {
    if (of >= 0 && of != slot) return;
    Mat<double, 3, 6> J = Mat<double, 3, 6>::Zero();
    J.rightCols<3>() = window.T_world_body(slot).R() / sigma;
    take(slot, J, residual(window));
  }
};

/// Points and lines through them in four keyframes. The names are those that WindowProblem uses of a backend.
struct TestBackend : test::SeenCollinear<double> {
  using S = double;
  using Landmarks = LandmarkSet<Store, LineStore>;
  using Layout = VisualLayout;
  using AllTerms = Landmarks::TupleOf<WindowTerms>;
  static constexpr int points = count * on_each, lines_at = 6 * used + points, dim = lines_at + 4 * count;

  Landmarks landmarks{StoreOptions{}, StoreOptions{}};
  Window window_ = window, backup_;
  NoFactors factors_{0};
  MeasuredPosition frame_factors_;
  WindowViews<S, slots> views_;
  WindowPriorOf<Window, AllTerms> prior_;
  RigPrior<Layout> rig_prior_{{}, {}};
  WindowEquations<Window> equations_;
  AllTerms terms_;
  LandmarkTies<Landmarks> ties_;

  /// Everything beside the truth, the first pose and the distance of the last one with a prior.
  TestBackend() {
    landmarks.get<0>() = *store;
    landmarks.get<1>() = *lines;
    Mat<double, 6, 6> J = 50 * Mat<double, 6, 6>::Identity();
    J(1, 4) = J(5, 2) = 10;
    prior_.set(window_, 0, J);
    const double distance = (window_.T_world_body(3).p() - window_.T_world_body(0).p()).norm();
    prior_.add_distance(window_, 0, 3, 1.001 * distance, 1e-3);
    frame_factors_.p_world = window_.T_world_body(2).p() + 3e-3 * noise.vector<3>();
    for (int k = 0; k < used; ++k) {
      Vec<double, 6> e;
      e << 1e-3 * noise.vector<3>(), 2e-3 * noise.vector<3>();
      window_.state(k).add(e);
    }
    for (auto& point : landmarks.get<0>().landmarks()) {
      point.geometry.inverse_range *= 1 + 0.005 * noise();
      for (auto& seen : point.observations) seen.uv += 0.2f * Vec<float, 2>(noise.vector<2>().cast<float>());
    }
    for (auto& line : landmarks.get<1>().landmarks())
      line.geometry.line = line.geometry.line.plus(Vec<double, 4>(1e-3 * noise.vector<4>()));
    equations_.order(window_);
    views_.update(window_, T_body_cam);
    ties_.choose(landmarks, views_);
  }
  double cost_of_frames() const {
    return prior_.cost(window_) + factors_.cost(window_) + rig_prior_.cost(window_) + frame_factors_.cost(window_);
  }
  void begin_linearization() {
    equations_.pairs.reset();
    views_.set_transports(window_, equations_.pairs);
  }

  struct Parts {
    double frames = 0, points = 0, lines = 0, ties = 0;
    double sum() const { return frames + points + lines + ties; }
  };
  static double huber(double k, double squared) {
    return squared > k * k ? 2 * k * std::sqrt(squared) - k * k : squared;
  }
  /// The costs where everything is moved by d: frames, inverse ranges, lines. From residuals, no terms.
  Parts parts(const VecX& d = VecX::Zero(dim)) const {
    Window moved = window_;
    VecX step = VecX::Zero(6 * slots);
    step.head(6 * used) = d.head(6 * used);
    moved.move(step);
    const auto T_world_cam = [&](int k) { return moved.T_world_body(k) * T_body_cam; };
    const auto lambda = [&](std::size_t i) {
      return landmarks.get<0>().landmarks()[i].geometry.inverse_range + d[6 * used + Eigen::Index(i)];
    };
    Parts out;
    out.frames = prior_.cost(moved) + frame_factors_.cost(moved);
    for (std::size_t i = 0; i < std::size_t(points); ++i) {
      const auto& point = landmarks.get<0>().landmarks()[i];
      const Vec<double, 3> p_world = T_world_cam(point.anchor) * Vec<double, 3>(point.geometry.bearing / lambda(i));
      for (int k = 0; k < used; ++k) {
        const auto& seen = point.observations[std::size_t(k)];
        if (k == point.anchor || !seen.valid) continue;
        const Vec<double, 2> uv = rig.vision.camera.project(T_world_cam(k).inverse() * p_world).uv;
        out.points += huber(2.45, (seen.L.cast<double>() * (uv - seen.uv.cast<double>())).squaredNorm()) / 2;
      }
    }
    for (std::size_t i = 0; i < std::size_t(count); ++i) {
      const auto& line = landmarks.get<1>().landmarks()[i];
      const Line3<double> in_anchor =
          line.geometry.line.plus(Vec<double, 4>(d.segment<4>(lines_at + 4 * Eigen::Index(i))));
      for (int k = 0; k < used; ++k) {
        const auto& seen = line.observations[std::size_t(k)];
        if (!seen.valid) continue;
        const auto& pixels = seen.pixels.measured;
        const Vec<double, 3> n =
            (T_world_cam(k).inverse() * T_world_cam(line.anchor) * in_anchor.plucker()).n.normalized();
        const Vec<double, 2> r(pixels.px_per_rad[0] * n.dot(pixels.bearing_start),
                               pixels.px_per_rad[1] * n.dot(pixels.bearing_end));
        out.lines += huber(2.45, (seen.pixels.L * r).squaredNorm()) / 2;
      }
      for (std::size_t p = on_each * i; p < on_each * (i + 1); ++p) {  // its points, by their distance times lambda
        const auto& point = landmarks.get<0>().landmarks()[p];
        const Vec<double, 3> P = T_world_cam(line.anchor).inverse() * T_world_cam(point.anchor) *
                                 Vec<double, 3>(point.geometry.bearing / lambda(p));
        const double distance = (P - in_anchor.closest_point()).cross(in_anchor.direction()).norm();
        out.ties += huber(2.45, std::pow(lambda(p) * distance / 0.003, 2)) / 2;
      }
    }
    return out;
  }
  VecX gradient() const {
    VecX out(dim);
    for (int c = 0; c < dim; ++c) {
      const double h = 1e-5;
      const VecX d = VecX::Unit(dim, c);
      out[c] = (8 * (parts(h * d).sum() - parts(-h * d).sum()) - (parts(2 * h * d).sum() - parts(-2 * h * d).sum())) /
               (12 * h);
    }
    return out;
  }
};
using Problem = WindowProblem<TestBackend>;

Problem problem_of(TestBackend& backend) { return {backend, backend.rig, backend.landmarks, backend.T_body_cam}; }

/// All numbers that a step changes.
std::vector<double> state_of(const TestBackend& backend) {
  std::vector<double> out;
  const auto add = [&](const auto& values) { out.insert(out.end(), values.data(), values.data() + values.size()); };
  const auto add_pose = [&](const SE3<double>& T) {
    add(Vec<double, 4>(T.rotation().quaternion().coeffs()));
    add(T.p());
  };
  for (int k = 0; k < TestBackend::used; ++k) {
    const auto& pose = backend.window_[k].state.get<state::Pose>();
    add_pose(pose.value());
    add_pose(pose.first_estimate());
    add(pose.correction());
  }
  for (const auto& point : backend.landmarks.get<0>().landmarks()) out.push_back(point.geometry.inverse_range);
  for (const auto& line : backend.landmarks.get<1>().landmarks()) {
    const auto plucker = line.geometry.line.plucker();
    add(plucker.n);
    add(plucker.v);
  }
  for (int i = 0; i < TestBackend::used; ++i) {
    for (int j = 0; j < TestBackend::used; ++j) {
      if (i != j) add(backend.views_(i, j).scaled_point(Vec<double, 3>(0.1, -0.2, 0.9), 0.3));
    }
  }
  return out;
}

}  // namespace

TEST_CASE("window_problem: the cost is that of frames, points, lines and ties, before and after a step") {
  const auto backend = std::make_unique<TestBackend>();
  Problem problem = problem_of(*backend);
  const TestBackend::Parts before = backend->parts();
  CAPTURE(before.frames, before.points, before.lines, before.ties);
  REQUIRE(std::min({before.frames, before.points, before.lines, before.ties}) > 0.5);
  CHECK(problem.linearize() == Approx(before.sum()).epsilon(1e-6));
  double predicted = 0;
  REQUIRE(problem.solve(1e-3, predicted));
  const double trial = problem.try_step();
  CHECK(trial == Approx(backend->parts().sum()).epsilon(1e-6));
  CHECK(trial < 0.7 * before.sum());
  CHECK(problem.linearize() == Approx(trial).epsilon(1e-9));
}

TEST_CASE("window_problem: a step that is rejected leaves no trace") {
  const auto backend = std::make_unique<TestBackend>();
  Problem problem = problem_of(*backend);
  const std::vector<double> before = state_of(*backend);
  const double cost = problem.linearize();
  double predicted = 0, again = 0;
  for (const double mu : {1e-6, 1.0, 100.0}) {
    CAPTURE(mu);
    REQUIRE(problem.solve(mu, predicted));
    problem.try_step();
    const std::vector<double> moved = state_of(*backend);
    int unmoved = 0;
    for (std::size_t i = 0; i < moved.size(); ++i) unmoved += moved[i] == before[i];
    REQUIRE(unmoved < int(moved.size()) / 4);  // first estimates, mostly
    problem.reject();
    REQUIRE(state_of(*backend) == before);
    // Solved once more without linearizing: what the step itself needs is untouched, too.
    REQUIRE(problem.solve(mu, again));
    REQUIRE(again == predicted);
    problem.try_step();
    REQUIRE(state_of(*backend) == moved);
    problem.reject();
  }
  REQUIRE(problem.linearize() == cost);
}

TEST_CASE("window_problem: an accepted step stays, and decreases the cost by what was predicted") {
  const auto backend = std::make_unique<TestBackend>();
  Problem problem = problem_of(*backend);
  for (int iteration = 0; iteration < 3; ++iteration) {  // the model is the cost itself near the minimum
    double predicted = 0;
    problem.linearize();
    REQUIRE(problem.solve(1e-3, predicted));
    problem.try_step();
    problem.accept();
  }
  const double before = problem.linearize();
  Vec<double, 6> e;
  e << 3e-4, -2e-4, 2e-4, 2e-4, -3e-4, 2e-4;
  backend->window_.state(2).add(e);
  backend->views_.update(backend->window_, backend->T_body_cam);
  const double displaced = problem.linearize();
  REQUIRE(displaced > before + 0.1);
  double predicted = 0;
  REQUIRE(problem.solve(0, predicted));
  const std::vector<double> start = state_of(*backend);
  const double after = problem.try_step();
  problem.accept();
  CHECK(state_of(*backend) != start);
  CHECK(displaced - after == Approx(predicted).epsilon(0.02));
  CHECK(after == Approx(before).epsilon(0.01));
}

TEST_CASE("window_problem: where it converges the gradient of all parts together is zero") {
  const auto backend = std::make_unique<TestBackend>();
  Problem problem = problem_of(*backend);
  const VecX at_start = backend->gradient();
  LevenbergMarquardtOptions options;
  options.max_iterations = 60;
  options.relative_cost_tolerance = 1e-14;
  options.step_tolerance = 1e-12;
  const LevenbergMarquardtSummary summary = levenberg_marquardt(problem, options);
  CAPTURE(summary.iterations, summary.initial_cost, summary.final_cost);
  const VecX at_end = backend->gradient();
  for (const auto& [at, n] :
       {std::pair{0, 6 * TestBackend::used}, std::pair{6 * TestBackend::used, TestBackend::points},
        std::pair{TestBackend::lines_at, 4 * TestBackend::count}}) {
    CAPTURE(at, at_start.segment(at, n).norm(), at_end.segment(at, n).norm());
    CHECK(at_end.segment(at, n).norm() < 1e-4 * at_start.segment(at, n).norm());
  }
}
