// One frame alone against Gauss-Newton over the same rows by Eigen, with numeric Jacobians.        docs/math/direct.md
#include "plumbline/backend/frame_solve.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "feature/residuals_of.hpp"
#include "feature/seen_points.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/propagation/constant_velocity.hpp"
#include "plumbline/propagation/inertial.hpp"
#include "plumbline/sensor/imu.hpp"
#include "residual/points.hpp"

using namespace plumbline;

namespace {

using MatX = Eigen::MatrixXd;
using VecX = Eigen::VectorXd;

constexpr int slots = 5, keyframe = 0, frame = 1, next = 2;
template <class PropagationT>
using Window = FrameWindow<double, typename PropagationT::Layout, slots>;

VecX random_values(Random& random, int n, double size) {
  VecX out(n);
  for (int k = 0; k < n; ++k) out[k] = size * (2 * random.uniform() - 1);
  return out;
}
template <int N>
Mat<double, N, N> random_covariance(Random& random, double sigma) {
  Mat<double, N, N> A;
  for (int c = 0; c < N; ++c) A.col(c) = random_values(random, N, 1);
  return sigma * sigma * (A * A.transpose() / N + 0.3 * Mat<double, N, N>::Identity());
}

/// Whitened differences of two states to a measured motion, every row of all parameters; Jacobians are numeric.
struct TestFactors {
  static constexpr int dim = InertialLayout::dim;
  int from = keyframe, to = frame;
  Mat<double, dim, dim> L = Mat<double, dim, dim>::Identity();
  SE3<double> T_from_to;
  Vec<double, 9> rest_change = Vec<double, 9>::Zero();  ///< of velocity and biases

  Vec<double, dim> residual(const NavState<double>& i, const NavState<double>& j) const {
    Vec<double, dim> r;
    r << minus(j.T_world_body, i.T_world_body * T_from_to), j.v_world_body - i.v_world_body - rest_change.head<3>(),
        j.bias_gyro - i.bias_gyro - rest_change.segment<3>(3), j.bias_accel - i.bias_accel - rest_change.tail<3>();
    r.tail<9>() += 0.3 * r.head<9>();
    return L * r;
  }
  void for_each_row(const auto& window, int slot, auto&& take) const {
    if (slot >= 0 && slot != from && slot != to) return;
    const auto i = window[from].state, j = window[to].state;
    const auto numeric = [&](bool of_i) {
      Mat<double, dim, dim> J;
      for (int c = 0; c < dim; ++c) {
        const auto at = [&](double step) {
          auto x = of_i ? i : j;
          x.add(step * Vec<double, dim>::Unit(c));
          return of_i ? residual(x.value(), j.value()) : residual(i.value(), x.value());
        };
        J.col(c) = (at(1e-6) - at(-1e-6)) / 2e-6;
      }
      return J;
    };
    take(from, numeric(true), to, numeric(false), Vec<double, dim>(Vec<double, dim>::Zero()),
         residual(i.value(), j.value()));
  }
};

/// NoFactors by default.
struct NothingTied : NoFactors {
  NothingTied() : NoFactors(0) {}
};

template <class PropagationT>
struct Scene {
  using Propagation = PropagationT;
  using Sensors = typename Propagation::Sensors;
  using Seen = test::SeenPoints<double, Sensors>;
  using Landmarks = LandmarkSet<typename Seen::Store>;
  using Solve = FrameSolve<Propagation, Landmarks>;
  static constexpr int dim = Propagation::Layout::dim, rest = dim - 6;
  using State = typename Window<Propagation>::State;

  Random random{7};
  Seen seen;
  std::unique_ptr<Landmarks> landmarks = std::make_unique<Landmarks>(StoreOptions{});
  std::conditional_t<(rest > 0), TestFactors, NothingTied> factors;
  Window<Propagation> window;
  Mat<double, dim, dim> of_keyframe = random_covariance<dim>(random, 0.02);
  FrameSolveOptions options;
  std::unique_ptr<Solve> solver = std::make_unique<Solve>();

  /// The frame sees what the fourth keyframe of `seen` does, from a position that is a little off.
  explicit Scene(int points = 20) : seen(points, 0.5) {
    for (auto& landmark : seen.store->landmarks()) landmark.geometry.sigma_inverse_range = 0.002;
    landmarks->template get<0>() = *seen.store;
    const auto state = [&](int k, double off) {
      typename Window<Propagation>::Value x;
      x.T_world_body = plus(seen.T_world_body[std::size_t(k)], Vec<double, 6>(random_values(random, 6, off)));
      if constexpr (rest > 0) x.v_world_body = random_values(random, 3, 0.3);
      return x;
    };
    window.insert(0, state(0, 0));
    window.insert(1, state(3, 0.01));
    options.max_iterations = 20;
    options.step_tolerance = 1e-11;
    options.linear_step = 0;
    options.weak_prior_sigma = 0.5;
    solver->set_keyframe(keyframe, of_keyframe);
    if constexpr (rest > 0) measure(keyframe, frame);
  }
  /// The motion between two frames with an error of the factor's covariance.
  void measure(int from, int to) requires(rest > 0) {
    factors.from = from;
    factors.to = to;
    factors.L = MatX(random_covariance<15>(random, 0.02).inverse()).llt().matrixU();
    factors.T_from_to = plus(window.T_world_body(from).inverse() * window.T_world_body(to),
                             Vec<double, 6>(random_values(random, 6, 0.01)));
    factors.rest_change = window[to].state.correction().template tail<9>() + random_values(random, 9, 0.02);
    factors.rest_change.template head<3>() +=
        window[to].state.value().v_world_body - window[from].state.value().v_world_body;
  }
  bool solve(int slot) { return solver->solve(seen.rig, seen.T_body_cam, *landmarks, window, factors, slot, options); }

  /// (10) by explicit inverses.
  static MatX rest_information(const MatX& C) {
    const MatX conditional = C.bottomRightCorner(rest, rest) -
                             C.bottomLeftCorner(rest, 6) * C.topLeftCorner(6, 6).inverse() * C.topRightCorner(6, rest);
    return conditional.inverse();
  }

  /// The normal equations of the frame in `slot` at x, and of the rest of the frame in `reference` at x_i. The prior of
  /// x is about `predicted`, that of x_i about what the window has, with the information `of_rest`.
  void equations(const State& x, const State& x_i, int slot, int reference, const State& predicted, const MatX& of_rest,
                 MatX& H, VecX& b) const {
    H = MatX::Zero(dim + rest, dim + rest);
    b = VecX::Zero(dim + rest);
    const auto moved = [&](int c, double step) {
      State out = x;
      out.add(step * Vec<double, dim>::Unit(c));
      return out;
    };
    using Kind = typename Seen::Kind;
    for (const auto& landmark : landmarks->template get<0>().landmarks()) {
      if (!landmark.current.valid) continue;
      const auto& point = landmark.geometry;
      const SE3<double> T_world_anchor = window.T_world_body(landmark.anchor) * seen.T_body_cam;
      const Vec<double, 3> p_cam = point.bearing / point.inverse_range;
      const auto residual = [&](const State& at, const Vec<double, 3>& p) {
        const Vec<double, 3> in_cam = (at.value().T_world_body * seen.T_body_cam).inverse() * (T_world_anchor * p);
        Vec<double, 3> r;
        r << seen.rig.vision.camera.project(in_cam).uv - landmark.current.uv.template cast<double>(),
            1 / in_cam.z() - landmark.current.depth.get().value;
        return r;
      };
      static_assert(std::is_same_v<typename Kind::Scalar, double>);
      Mat<double, 3, 6> J;
      for (int c = 0; c < 6; ++c)
        J.col(c) = (residual(moved(c, 1e-6), p_cam) - residual(moved(c, -1e-6), p_cam)) / 2e-6;
      const double h = 1e-5;
      const auto at_range = [&](double lambda) { return residual(x, point.bearing / lambda); };
      const Vec<double, 3> by_sigma =
          point.sigma_inverse_range / (2 * h) * (at_range(point.inverse_range + h) - at_range(point.inverse_range - h));
      const Vec<double, 3> r = residual(x, p_cam);
      const Mat<double, 2, 2> L = landmark.current.L.template cast<double>();
      const Mat<double, 2, 2> C = (L.transpose() * L).inverse() + by_sigma.head<2>() * by_sigma.head<2>().transpose();
      const double sigma_z = landmark.current.depth.get().sigma,
                   variance_z = sigma_z * sigma_z + by_sigma[2] * by_sigma[2];
      const Mat<double, 2, 2> information = C.inverse();
      const auto huber = [](double k, double squared) { return squared > k * k ? k / std::sqrt(squared) : 1.0; };
      const double w = huber(2.45, r.head<2>().dot(information * r.head<2>()));
      const double w_z = huber(1.345, r[2] * r[2] / variance_z) / variance_z;
      H.topLeftCorner<6, 6>() += w * J.topRows<2>().transpose() * information * J.topRows<2>();
      H.topLeftCorner<6, 6>() += w_z * J.row(2).transpose() * J.row(2);
      b.head<6>() += w * J.topRows<2>().transpose() * (information * r.head<2>());
      b.head<6>() += w_z * J.row(2).transpose() * r[2];
    }
    if constexpr (rest > 0) {
      const double w = 1 / (options.weak_prior_sigma * options.weak_prior_sigma);
      H.block<rest, rest>(6, 6) += w * MatX::Identity(rest, rest);
      b.segment<rest>(6) += w * (x.correction() - predicted.correction()).template tail<rest>();
      H.bottomRightCorner<rest, rest>() += of_rest;
      b.tail<rest>() += of_rest * (x_i.correction() - window[reference].state.correction()).template tail<rest>();
      auto moved_window = window;
      moved_window.state(slot) = x;
      moved_window.state(reference) = x_i;
      factors.for_each_row(moved_window, slot,
                           [&](int, const auto& J_i, int, const auto& J_j, const auto&, const auto& r) {
                             MatX J(15, dim + rest);
                             J << J_j, J_i.template rightCols<rest>();
                             H += J.transpose() * J;
                             b += J.transpose() * r;
                           });
    }
  }

  struct Solution {
    State x;
    MatX covariance;  ///< of the frame, the pose of its reference being given
  };
  Solution dense(int slot, int reference, const MatX& of_reference) const {
    State x = window[slot].state, x_i = window[reference].state;
    const State predicted = x;
    MatX of_rest, H;
    if constexpr (rest > 0) of_rest = rest_information(of_reference);
    VecX b;
    for (int iteration = 0; iteration < 12; ++iteration) {
      equations(x, x_i, slot, reference, predicted, of_rest, H, b);
      const VecX d = -H.ldlt().solve(b);
      x.add(d.head<dim>());
      Vec<double, dim> d_i = Vec<double, dim>::Zero();
      d_i.template tail<rest>() = d.tail<rest>();
      x_i.add(d_i);
    }
    equations(x, x_i, slot, reference, predicted, of_rest, H, b);
    return {x, H.inverse().topLeftCorner<dim, dim>()};
  }
  /// Adjoint of T_j^-1 T_i: how an increment of T_i moves T_j where their relative pose is given, numerically.
  Mat<double, 6, 6> carry(int from, int to) const {
    const SE3<double> T_i = window.T_world_body(from), T_j = window.T_world_body(to);
    Mat<double, 6, 6> J;
    for (int c = 0; c < 6; ++c) {
      const auto at = [&](double step) {
        return minus(plus(T_i, Vec<double, 6>(step * Vec<double, 6>::Unit(c))) * T_i.inverse() * T_j, T_j);
      };
      J.col(c) = (at(1e-6) - at(-1e-6)) / 2e-6;
    }
    return J;
  }
  double difference_from(const Solution& solution, int slot) const {
    const auto found = window[slot].state.value(), wanted = solution.x.value();
    double out = minus(found.T_world_body, wanted.T_world_body).norm();
    if constexpr (rest > 0) {
      out += (found.v_world_body - wanted.v_world_body).norm() + (found.bias_gyro - wanted.bias_gyro).norm() +
             (found.bias_accel - wanted.bias_accel).norm();
    }
    return out;
  }
};

using Visual = ConstantVelocity<Rig<Rgbd<Pinhole<double>, 64 * 64>>>;
using WithImu = Inertial<Rig<Rgbd<Pinhole<double>, 64 * 64>, Imu>>;

double relative(const MatX& found, const MatX& wanted) { return (found - wanted).norm() / wanted.norm(); }

}  // namespace

TEMPLATE_TEST_CASE("frame_solve: the state and (11) are those of a dense solution of the same rows", "", Visual,
                   WithImu) {
  using S = Scene<TestType>;
  S scene;
  const auto before = scene.window;
  const auto wanted = scene.dense(frame, keyframe, scene.of_keyframe);
  REQUIRE(scene.difference_from(wanted, frame) > 0.005);  // there is something to solve for
  REQUIRE(scene.solve(frame));
  CHECK(scene.difference_from(wanted, frame) < 1e-7);
  // The keyframe is the window's.
  CHECK(minus(scene.window.T_world_body(keyframe), before.T_world_body(keyframe)).norm() == 0);
  CHECK((scene.window[keyframe].state.correction() - before[keyframe].state.correction()).norm() == 0);

  Mat<double, 6, 6> found;
  REQUIRE(scene.solver->covariance(scene.window, frame, found));
  const Mat<double, 6, 6> Ad = scene.carry(keyframe, frame);
  const MatX expected = Ad * scene.of_keyframe.template topLeftCorner<6, 6>() * Ad.transpose() +
                        wanted.covariance.template topLeftCorner<6, 6>();
  CHECK(relative(found, expected) < 1e-5);
}

TEMPLATE_TEST_CASE("frame_solve: features that are not linearized again change the result by the square of the step",
                   "", Visual, WithImu) {
  Scene<TestType> scene;
  const auto wanted = scene.dense(frame, keyframe, scene.of_keyframe);
  scene.options = {};
  scene.options.weak_prior_sigma = 0.5;
  REQUIRE(scene.solve(frame));
  CHECK(scene.difference_from(wanted, frame) < 2e-5);
}

TEST_CASE("frame_solve: a frame that was solved alone is the reference of the next one, with its covariance") {
  Scene<WithImu> scene;
  const auto alone = scene.dense(frame, keyframe, scene.of_keyframe);
  REQUIRE(scene.solve(frame));
  Mat<double, 6, 6> of_pose;
  REQUIRE(scene.solver->covariance(scene.window, frame, of_pose));
  scene.window.insert(2, scene.window[frame].state.value());
  scene.measure(frame, next);
  scene.solver->set_reference(scene.window, scene.factors, frame, scene.options);
  const auto wanted = scene.dense(next, frame, alone.covariance);
  REQUIRE(scene.solve(next));
  CHECK(scene.difference_from(wanted, next) < 1e-6);
  Mat<double, 6, 6> found;
  REQUIRE(scene.solver->covariance(scene.window, next, found));
  const Mat<double, 6, 6> Ad = scene.carry(frame, next);
  CHECK(relative(found, Ad * of_pose * Ad.transpose() + wanted.covariance.topLeftCorner<6, 6>()) < 1e-5);
}

TEST_CASE("frame_solve: a frame without image has the covariance that its factor propagates") {
  Scene<WithImu> scene;
  scene.window.insert(2, scene.window[frame].state.value());
  // Frame and keyframe together: 30 parameters, with all of the keyframe's covariance.
  MatX H = MatX::Zero(30, 30);
  H.bottomRightCorner<15, 15>() = scene.of_keyframe.inverse();
  H.block<9, 9>(6, 6) += MatX::Identity(9, 9) / (scene.options.weak_prior_sigma * scene.options.weak_prior_sigma);
  scene.factors.for_each_row(scene.window, frame,
                             [&](int, const auto& J_i, int, const auto& J_j, const auto&, const auto&) {
                               MatX J(15, 30);
                               J << J_j, J_i;
                               H += J.transpose() * J;
                             });
  const MatX propagated = H.inverse().topLeftCorner<15, 15>();

  scene.solver->set_reference(scene.window, scene.factors, frame, scene.options);
  scene.measure(frame, next);
  const auto wanted = scene.dense(next, frame, propagated);
  REQUIRE(scene.solve(next));
  CHECK(scene.difference_from(wanted, next) < 1e-6);
  Mat<double, 6, 6> found;
  REQUIRE(scene.solver->covariance(scene.window, next, found));
  const Mat<double, 6, 6> Ad = scene.carry(frame, next);
  const MatX expected =
      Ad * propagated.topLeftCorner<6, 6>() * Ad.transpose() + wanted.covariance.topLeftCorner<6, 6>();
  CHECK(relative(found, expected) < 1e-5);
}

TEST_CASE("frame_solve: what the rows do not determine is not solved for, and nothing moves") {
  Scene<Visual> scene(2);
  for (auto& landmark : scene.landmarks->get<0>().landmarks()) landmark.current.valid = false;
  const SE3<double> before = scene.window.T_world_body(frame);
  REQUIRE_FALSE(scene.solve(frame));
  CHECK(minus(scene.window.T_world_body(frame), before).norm() == 0);
  Mat<double, 6, 6> covariance;
  CHECK_FALSE(scene.solver->covariance(scene.window, frame, covariance));
}
