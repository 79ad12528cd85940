// The window on simulated observations with exact truth: convergence, consistency of its covariance, and what must
// never become known, the place and attitude of the whole.                                  docs/math/window.md
#include "plumbline/backend/window_backend.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/testing/simulated_points.hpp"

using namespace plumbline;

namespace {

/// A camera that looks around in a cloud of points: some centimeters and `turn` radians from keyframe to keyframe.
SE3<double> pose_at(int k, double turn) {
  const double a = 0.12 * k;
  return SE3<double>(SO3<double>::exp({0, turn * k, 0}) * SO3<double>::exp({0.1 * std::sin(a), 0, 0.1 * std::cos(a)}),
                     Vec<double, 3>(0.8 * std::sin(a), 0.2 * std::sin(2 * a), 0.8 * std::cos(a)));
}

template <class S, int K = 6>
struct Run {
  using Sensors = Rig<Rgbd<Pinhole<S>>>;
  using Landmarks = typename Features<Points<120>>::template Landmarks<Sensors, K>;
  using Backend = WindowBackend<ConstantVelocity<Sensors>, Landmarks, K>;

  testing::SimulatedPoints points;
  double turn;  ///< [rad] from keyframe to keyframe
  WindowOptions options;
  testing::Gaussian noise;
  Sensors rig{};
  std::unique_ptr<Landmarks> landmarks = std::make_unique<Landmarks>(StoreOptions{});
  std::unique_ptr<Backend> backend;
  SE3<double> T_start;  ///< initial estimate of the first keyframe
  SE3<double> T_moved;  ///< by which the window was moved as a whole since, (7)
  int keyframes = 0, retirements = 0;
  LevenbergMarquardtSummary summary;

  Run(std::uint64_t seed, double noise_scale, double turn_rad = 0.05, double sigma_first = 1e-3, double mu = 1e-4)
      : turn(turn_rad), noise(seed) {
    points.noise_scale = noise_scale;
    points.scatter(900, {3.5, 2, 3.5}, seed + 100);
    rig.vision.camera = {S(460), S(460), S(319.5), S(239.5), {}};
    options.sigma_first_rotation = options.sigma_first_position = sigma_first;
    options.solver.max_iterations = 20;
    options.solver.mu_initial = mu;
    backend = std::make_unique<Backend>(options, ConstantVelocityOptions{});
  }

  /// One more keyframe: guessed, seen, optimized, and one leaves when there is no room for the next.
  void add_keyframe() {
    const SE3<double> T = pose_at(keyframes, turn);
    Vec<double, 6> error;
    error << 0.01 * noise.vector<3>(), 0.02 * noise.vector<3>();
    int slot;
    if (keyframes == 0) {
      T_start = plus(T, Vec<double, 6>(points.noise_scale * options.sigma_first_position * noise.vector<6>()));
      slot = backend->start(0, {T_start.template cast<S>()});
    } else {
      const SE3<double> T_believed = T_start * pose_at(0, turn).inverse() * T;
      slot = backend->insert(keyframes, {plus(T_believed, error).template cast<S>()}, {});
    }
    landmarks->for_each([&](auto& store) {
      for (std::size_t i = store.landmarks().size(); i-- > 0;) {  // those out of sight and seen too little make room
        if (!store.landmarks()[i].current.valid && store.landmarks()[i].observation_count() < 3) {
          store.landmarks().swap_remove(i);
        }
      }
      points.observe(store, T, slot, noise);
    });
    const SE3<double> before = first_estimate_of_oldest();
    summary = optimize();
    T_moved = first_estimate_of_oldest() * before.inverse() * T_moved;
    ++keyframes;
  }
  void make_room() {
    if (!backend->window().full()) return;
    NoMap::Discard<S> map;
    backend->retire(rig, {}, *landmarks, backend->window().oldest(), map);
    ++retirements;
  }
  LevenbergMarquardtSummary optimize() { return backend->optimize(rig, {}, *landmarks); }
  void add_keyframes(int count) {
    for (int i = 0; i < count; ++i) {
      make_room();
      add_keyframe();
    }
  }

  /// A prior refers to it: it moves with the whole window alone.
  SE3<double> first_estimate_of_oldest() const {
    return backend->window()[backend->window().oldest()].state.first_estimate().T_world_body.template cast<double>();
  }
  SE3<double> truth() const { return pose_at(keyframes - 1, turn); }
  SE3<double> estimate() const {
    return backend->window().T_world_body(backend->window().newest()).template cast<double>();
  }
  Vec<double, 6> error() const { return minus(estimate(), truth()); }
  Mat<double, 6, 6> covariance() const {
    Mat<S, 6, 6> out = Mat<S, 6, 6>::Zero();
    REQUIRE(backend->covariance_of_newest(out));
    return out.template cast<double>();
  }
  /// Normalized estimation error squared, chi-square with six degrees of freedom for a consistent estimate.
  double nees() const { return error().dot(covariance().ldlt().solve(error())); }

  /// Covariance of the newest pose that the first keyframe's prior alone would give, all else perfectly known: no
  /// measurement of points determines the pose of the whole, so the estimate's can never be below.
  Mat<double, 6, 6> covariance_of_the_whole() const {
    const SE3<double> T_newest =
        backend->window()[backend->window().newest()].state.first_estimate().T_world_body.template cast<double>();
    const Mat<double, 6, 6> Ad =
        (T_newest.inverse() * T_moved * T_start.template cast<S>().template cast<double>()).adjoint();
    const double sigma = options.sigma_first_position;
    return sigma * sigma * Ad * Ad.transpose();
  }
  /// How much smaller than it can be the covariance is in its best known direction: 1 or more is right.
  double information_kept_out() const {
    const Eigen::GeneralizedSelfAdjointEigenSolver<Mat<double, 6, 6>> eigen(covariance(), covariance_of_the_whole());
    return eigen.eigenvalues().minCoeff();
  }
};

}  // namespace

TEMPLATE_TEST_CASE("window_backend: without noise it converges to the truth, keyframe after keyframe", "", float,
                   double) {
  using S = TestType;
  constexpr bool single = std::is_same_v<S, float>;
  Run<S> run(1, 0);
  for (int k = 0; k < 20; ++k) {
    run.add_keyframes(1);
    CAPTURE(k);
    REQUIRE((k == 0 || run.summary.initial_cost > 10));
    REQUIRE(run.summary.final_cost < (single ? 1e-2 : 1e-6));
    REQUIRE(run.error().norm() < (single ? 1e-3 : 1e-5));
  }
  REQUIRE(run.retirements == 14);
}

TEST_CASE("window_backend: the covariance of the newest pose is that of its errors") {
  constexpr int seeds = 30, dof = 6;
  double sum = 0, worst = 0, sum_later = 0;
  for (int seed = 0; seed < seeds; ++seed) {
    Run<double> run(std::uint64_t(seed), 1);
    run.add_keyframes(6);  // nothing marginalized
    REQUIRE(run.retirements == 0);
    sum += run.nees();
    worst = std::max(worst, run.nees());
    run.add_keyframes(20);
    sum_later += run.nees();
  }
  const double mean = sum / (seeds * dof), mean_later = sum_later / (seeds * dof);
  // The sum is chi-square with 180 degrees of freedom: 99.9 % of it are within 0.69 and 1.38 of their number.
  CAPTURE(mean, mean_later, worst);
  REQUIRE(mean > 0.69);
  REQUIRE(mean < 1.38);
  REQUIRE(mean_later > 0.69);
  REQUIRE(mean_later < 1.38);
}

TEST_CASE("window_backend: the covariance does not depend on the damping of the last step") {
  Run<double> run(6, 1);
  run.add_keyframes(6);
  const Mat<double, 6, 6> covariance = run.covariance();
  LevenbergMarquardtOptions damped = run.options.solver;
  damped.mu_initial = 1e3;
  damped.max_iterations = 1;
  run.backend->optimize(run.rig, {}, *run.landmarks, damped);
  REQUIRE((run.covariance() - covariance).norm() < 1e-3 * covariance.norm());
}

TEST_CASE("window_backend: the pose of the whole is not observable, after any marginalization") {
  // The prior of the first pose is wide and the damping is negligible, so that any other information shows.
  Run<double> run(3, 1, 0.1, 0.1, 1e-12);
  for (int k = 0; k < 40; ++k) {
    run.add_keyframes(1);
    CAPTURE(k);
    REQUIRE(run.information_kept_out() > 1 - 1e-6);
  }
  REQUIRE(run.retirements > 30);
}

TEST_CASE("window_backend: a distance that defines the unit of length is known from then on, and nothing else") {
  Run<double> run(7, 1, 0.05, 1e-6);
  run.add_keyframes(2);
  const auto& window = run.backend->window();
  const Vec<double, 3> between = window.T_world_body(1).p() - window.T_world_body(0).p();
  const Vec<double, 3> along = window.T_world_body(1).rotation().inverse() * Vec<double, 3>(between.normalized());
  const auto sigma = [&](const Vec<double, 3>& direction) {
    return std::sqrt(direction.dot(run.covariance().bottomRightCorner<3, 3>() * direction));
  };
  const Vec<double, 3> across = along.unitOrthogonal();
  const double sigma_across = sigma(across), held = run.options.sigma_first_scale * between.norm();
  REQUIRE(sigma(along) > 5 * held);
  const double cost = run.summary.final_cost;
  run.backend->hold_scale(0, 1);
  run.summary = run.optimize();
  CHECK(run.summary.initial_cost == Approx(cost).epsilon(1e-6));  // the distance is as it is
  CHECK(sigma(along) == Approx(held).epsilon(0.05));
  CHECK(sigma(across) > 0.5 * sigma_across);
}

TEMPLATE_TEST_CASE("window_backend: the oldest keyframe holds the window in its world", "", float, double) {
  using S = TestType;
  constexpr double tolerance = std::is_same_v<S, float> ? 2e-6 : 1e-12;
  Run<S> run(11, 1);
  const auto& window = run.backend->window();
  for (int k = 0; k < 30; ++k) {
    run.make_room();
    const SE3<S> oldest = k > 0 ? window.T_world_body(window.oldest()) : SE3<S>();
    run.add_keyframe();
    if (k == 0) continue;
    REQUIRE(run.summary.accepted > 0);
    REQUIRE(minus(window.T_world_body(window.oldest()), oldest).norm() < tolerance);
    // All residuals are those of the solution.
    LevenbergMarquardtOptions none;
    none.max_iterations = 0;
    const LevenbergMarquardtSummary again = run.backend->optimize(run.rig, {}, *run.landmarks, none);
    REQUIRE(again.initial_cost == Approx(run.summary.final_cost).epsilon(1e4 * tolerance));
  }
  REQUIRE(run.retirements > 20);
}

TEST_CASE("window_backend: the same input gives the same output to the last bit") {
  Run<float> a(2, 1), b(2, 1);
  for (int k = 0; k < 12; ++k) {
    a.add_keyframes(1);
    b.add_keyframes(1);
    REQUIRE(a.estimate().p() == b.estimate().p());
    REQUIRE(a.covariance() == b.covariance());
    REQUIRE(a.summary.final_cost == b.summary.final_cost);
  }
}

TEST_CASE("window_backend: an observation that is not finite is dropped, and the window is not affected") {
  Run<double> run(4, 1);
  run.add_keyframes(4);
  const int slot = run.backend->window().newest();
  run.landmarks->for_each([&](auto& store) {
    for (auto& landmark : store.landmarks()) {
      if (landmark.anchor != slot && landmark.observations[std::size_t(slot)].valid) {
        landmark.observations[std::size_t(slot)].uv.x() = std::nanf("");
        break;
      }
    }
  });
  const SE3<double> before = run.estimate();
  REQUIRE(run.optimize().termination == LevenbergMarquardtEnd::not_finite);
  REQUIRE(minus(run.estimate(), before).norm() == 0);
  REQUIRE(std::isfinite(run.optimize().final_cost));
  run.add_keyframes(10);
  REQUIRE(run.error().norm() < 0.02);
}

TEMPLATE_TEST_CASE("window_backend: in fast rotation the prior holds the window to the world", "", float, double) {
  Run<TestType> run(5, 1, 0.35);  // 20 degrees from keyframe to keyframe: few landmarks live long
  run.add_keyframes(6);
  const double before = std::sqrt(run.covariance().template bottomRightCorner<3, 3>().trace());
  double sigma = before;
  while (run.retirements < 60) {
    run.add_keyframes(1);
    sigma = std::sqrt(run.covariance().template bottomRightCorner<3, 3>().trace());
    CAPTURE(run.keyframes, before, sigma);
    REQUIRE(sigma < before * std::sqrt(double(run.keyframes)));
    REQUIRE(run.error().template tail<3>().norm() < 5 * sigma);
  }
}

namespace {

/// The run with a shutter that rolls for 20 ms, thought to read all rows at once: everything is seen where the rows saw
/// it, from a camera that turns otherwise in every keyframe.
template <class S>
struct RollingRun : Run<S> {
  static constexpr double readout = 0.02;
  double found_s = 0, sigma_s = 0.02;

  explicit RollingRun(std::uint64_t seed, double noise_scale) : Run<S>(seed, noise_scale) {
    this->backend->set_readout_prior(0, sigma_s);
  }
  void observe_rolling(int slot) {
    using Rolling = typename Run<S>::Sensors;
    typename Rolling::Shutter::template Model<typename Rolling::Camera> shutter(this->rig.vision.camera, 480, S(0));
    shutter.set_motion((0.6 * this->noise.template vector<3>()).template cast<S>(), Vec<S, 3>::Zero(), S(0.3));
    const auto rolled = [&](auto& x, const auto& derivative) { x -= float(readout - found_s) * derivative; };
    this->landmarks->for_each([&](auto& store) {
      for (auto& landmark : store.landmarks()) {
        auto& seen = landmark.observations[std::size_t(slot)];
        if (!seen.valid) continue;
        const Vec<S, 2> uv = seen.uv.template cast<S>();
        seen.derivative.set(
            {shutter.still(uv, S(0)).derivative.by_rotation.template cast<float>(), Vec<float, 2>::Zero(), 0.3f});
        rolled(seen.uv, seen.derivative.get().by_rotation);
        landmark.current = seen;
        if (landmark.anchor != slot) continue;
        const auto derivative = shutter.bearing_derivative(uv, landmark.geometry.bearing, S(0));
        landmark.geometry.derivative.set({derivative.by_rotation, Vec<S, 3>::Zero(), S(0.3)});
        landmark.geometry.bearing = normalized(landmark.geometry.bearing -
                                               S(readout - found_s) * landmark.geometry.derivative.get().by_rotation);
      }
    });
  }
  void add_keyframe() {
    this->make_room();
    Run<S>::add_keyframe();
    observe_rolling(this->backend->window().newest());
    this->optimize();
    ReadoutCorrection found;
    if (!this->backend->find_readout(this->rig, {}, *this->landmarks, found)) return;
    found_s += found.value_s;
    sigma_s = found.sigma_s;
    this->backend->set_readout(found_s);
    this->landmarks->for_each([&](auto& store) { store.change_readout(S(found.value_s)); });
  }
};

}  // namespace

TEMPLATE_TEST_CASE("window_backend: without noise the readout time of the shutter is found", "", float, double) {
  RollingRun<TestType> run(1, 0);
  for (int k = 0; k < 12; ++k) run.add_keyframe();
  CAPTURE(run.found_s, run.sigma_s, run.error().norm());
  REQUIRE(run.retirements > 4);
  REQUIRE(run.found_s == Approx(run.readout).margin(2e-5));
  REQUIRE(run.error().norm() < 2e-3);
}

TEST_CASE(
    "window_backend: the error of the readout time is consistent with its sigma, frames and landmarks being unknown") {
  double squares = 0, worst_sigma = 0;
  const int runs = 20;
  for (int n = 0; n < runs; ++n) {
    RollingRun<double> run(std::uint64_t(n) + 1, 1);
    for (int k = 0; k < 12; ++k) run.add_keyframe();
    squares += std::pow((run.found_s - run.readout) / run.sigma_s, 2);
    worst_sigma = std::max(worst_sigma, run.sigma_s);
    REQUIRE(run.error().norm() < 0.05);
  }
  CAPTURE(squares, worst_sigma);
  REQUIRE(worst_sigma < 1e-3);
  REQUIRE(squares / runs > 0.3);
  REQUIRE(squares / runs < 2.2);
}
