#pragma once
/// The newest frame alone, its map being given and its keyframe known up to what the window left open: Gauss-Newton over
/// the rows of its features and of its links.                                               docs/math/direct.md
///
///   landmarks are given with their own uncertainty, as in the estimate of the pose (feature/motion_terms.hpp)
///   link:   r(x_i, x_j),  x_i the keyframe's state, its pose given, the rest known up to C                      (10)
///           Sigma = I + J_i C J_i^T of the whitened rows
///   C = Sigma_rr - Sigma_rp Sigma_pp^-1 Sigma_pr    from the window's covariance of the keyframe                (11)
///   Sigma_j = Ad Sigma_pp Ad^T + Sigma_relative     of the frame's pose, Ad = Ad(T_world_j^-1 T_world_i)        (12)
/// The place of keyframe and landmarks in the world is common to all of them, and given.

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/feature/motion_terms.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/motion/motion_model.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/solver/cholesky.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

struct FrameSolveOptions {
  int max_iterations = 4;
  double step_tolerance = 1e-5;  ///< converged below this length of the pose's step [rad and m]
  double sigma_rest = 1;         ///< of what no link ties (velocity [m/s], biases), about the prediction
};

template <MotionModel Motion, class Landmarks>
class FrameSolve {
 public:
  using Sensors = typename Motion::Sensors;
  using S = typename Motion::S;
  using Layout = typename Motion::Layout;
  static constexpr int dim = Layout::dim, pose_dim = state::Pose::dim, rest_dim = dim - pose_dim;
  using PoseCovariance = Mat<S, pose_dim, pose_dim>;
  using Covariance = Mat<S, dim, dim>;

  /// The keyframe's covariance in the window.
  void set_keyframe(const Covariance& covariance) {
    pose_of_keyframe_ = block<pose_dim, pose_dim>(covariance, 0, 0);
    rest_of_keyframe_.setZero();
    if constexpr (rest_dim > 0) {
      Cholesky<S, pose_dim> factor;
      if (!factor.compute(pose_of_keyframe_, Vec<S, pose_dim>(Vec<S, pose_dim>::Zero()))) return;
      for (int c = 0; c < rest_dim; ++c) {
        Vec<S, pose_dim> by_pose = block<pose_dim, 1>(covariance, 0, pose_dim + c);
        factor.solve_in_place(by_pose);
        for (int r = 0; r < rest_dim; ++r) {
          S explained = S(0);
          for (int k = 0; k < pose_dim; ++k) explained += covariance(pose_dim + r, k) * by_pose[k];
          rest_of_keyframe_(pose_dim + r, pose_dim + c) = covariance(pose_dim + r, pose_dim + c) - explained;  // (11)
        }
      }
    }
  }

  /// Moves the state of the frame in `slot`; false, and nothing moved, when the rows do not determine it.
  template <class Window>
  bool solve(const Sensors& rig, const SE3<S>& T_body_cam, const Landmarks& landmarks, Window& window,
             const auto& links, int slot, const FrameSolveOptions& options) {
    landmarks.for_each_with(terms_, [&](const auto& store, auto& terms) { terms.collect(store, window, T_body_cam); });
    const typename Window::State before = window.state(slot);
    DenseNormalEquations<S, dim> system;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      system.reset();
      DenseNormalEquations<S, pose_dim> features;
      const BodyView<S> body(window.T_world_body(slot), T_body_cam);
      landmarks.for_each_with(terms_, [&](const auto&, auto& terms) { terms.accumulate(rig, body, features); });
      system.add(features);
      add_rest(before, window.state(slot), S(options.sigma_rest), system);
      links.for_each_row(window, slot, [&](int i, const auto& J_i, int j, const auto& J_j, const auto& r) {
        if (j == slot && i != slot) add_link(J_i, J_j, r, system);
      });
      Vec<S, dim> d;
      if (!system.solve(d)) {
        window.state(slot) = before;
        return false;
      }
      window.state(slot).add(d);
      if (segment<pose_dim>(d, 0).norm() < S(options.step_tolerance)) break;
    }
    Covariance covariance;
    known_ = system.covariance(covariance);
    if (known_) relative_ = block<pose_dim, pose_dim>(covariance, 0, 0);
    return true;
  }

  /// (12) of the frame that was solved last; false when it is not defined.
  bool covariance(const SE3<S>& T_world_keyframe, const SE3<S>& T_world_body, PoseCovariance& out) const {
    const PoseCovariance Ad = (T_world_body.inverse() * T_world_keyframe).adjoint();
    out = product_transposed(product(Ad, pose_of_keyframe_), Ad) + relative_;
    return known_;
  }

 private:
  /// Rows (10).
  template <int Rows, class T>
  static void add_whitened(const Mat<T, Rows, Rows>& Sigma, const Mat<T, Rows, dim>& J_j, const Vec<T, Rows>& r,
                           DenseNormalEquations<S, dim>& system) {
    const auto L = square_root_information(Sigma);
    if (L) system.add(product(*L, J_j), product(*L, r), S(1));
  }
  template <int Rows, class T>
  void add_link(const Mat<T, Rows, dim>& J_i, const Mat<T, Rows, dim>& J_j, const Vec<T, Rows>& r,
                DenseNormalEquations<S, dim>& system) const {
    const Covariance& C = rest_of_keyframe_;
    Mat<T, Rows, dim> JC = Mat<T, Rows, dim>::Zero();
    for (int c = pose_dim; c < dim; ++c) {
      for (int k = pose_dim; k < dim; ++k) {
        for (int row = 0; row < Rows; ++row) JC(row, c) += J_i(row, k) * C(k, c);
      }
    }
    Mat<T, Rows, Rows> Sigma = product_transposed(JC, J_i);
    for (int k = 0; k < Rows; ++k) Sigma(k, k) += T(1);
    add_whitened(Sigma, J_j, r, system);
  }

  static void add_rest(const auto& before, const auto& now, S sigma, DenseNormalEquations<S, dim>& system) {
    if constexpr (rest_dim > 0) {
      const Vec<S, dim> moved = now.correction() - before.correction();
      Mat<S, rest_dim, dim> J = Mat<S, rest_dim, dim>::Zero();
      Vec<S, rest_dim> r;
      for (int k = 0; k < rest_dim; ++k) {
        J(k, pose_dim + k) = 1 / sigma;
        r[k] = moved[pose_dim + k] / sigma;
      }
      system.add(J, r, S(1));
    }
  }

  typename Landmarks::template TupleOf<MotionTerms> terms_;
  PoseCovariance pose_of_keyframe_ = PoseCovariance::Zero(), relative_ = PoseCovariance::Zero();
  Covariance rest_of_keyframe_ = Covariance::Zero();  ///< C of (11); zero but for the rest
  bool known_ = false;
};

}  // namespace plumbline
