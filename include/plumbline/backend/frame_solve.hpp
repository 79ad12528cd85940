#pragma once
/// Solution for the state of the newest frame alone, landmarks fixed, together with velocity and biases of its
/// keyframe: Gauss-Newton over the rows of its features and of its factor.                          docs/math/direct.md
///
///   Landmarks enter with their own covariance, as in pose refinement (feature/motion_terms.hpp).
///   Unknowns: the state x_j of the frame and, of its keyframe i, the blocks besides the pose (velocity, biases).
///   |L d_i|^2         ,   (L^T L)^-1 = Sigma_rr - Sigma_rp Sigma_pp^-1 Sigma_pr                                (10)
///                         Sigma: covariance of x_i in the window, p: its pose, r: its other blocks
///   Sigma_j = Ad Sigma_pp Ad^T + Sigma_relative   of the frame's pose, Ad = Ad(T_world_j^-1 T_world_i)         (11)
/// The pose of the keyframe is fixed: its uncertainty is common to keyframe and landmarks, and (11) adds it. The rows
/// (r, J) of factors of the frame alone are relative to the world, so it adds to their covariance:
///   |L_f (r + J d_j)|^2   ,   (L_f^T L_f)^-1 = I + J_p Ad Sigma_pp Ad^T J_p^T,   J_p: columns of the pose
///                                                                                        docs/math/factors.md (5)

#include "plumbline/core/matrix.hpp"
#include "plumbline/core/square_root_information.hpp"
#include "plumbline/factor/frame_factors.hpp"
#include "plumbline/feature/motion_terms.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/propagation/propagation.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/solver/cholesky.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/state/layout.hpp"

namespace plumbline {

struct FrameSolveOptions {
  int max_iterations = 4;  ///< Gauss-Newton iterations of one frame; tuned: docs/decisions/134 (chosen)
  /// Converged below this norm of the pose increment [rad and m]; numerics: below the noise of a pose.
  double step_tolerance = 1e-5;
  /// Feature rows are not relinearized after a pose increment below this norm [rad and m]; tuned: docs/decisions/060.
  double linear_step = 2e-3;
  /// Sigma about the prediction of velocity [m/s] and biases, which regularizes them without a factor;
  /// numerics: weaker than any factor.
  double weak_prior_sigma = 1;
};

template <Propagation PropagationT, class Landmarks>
class FrameSolve {
 public:
  using Sensors = typename PropagationT::Sensors;
  using S = typename PropagationT::S;
  using Layout = typename PropagationT::Layout;
  static constexpr int dim = Layout::dim, pose_dim = state::Pose::dim, non_pose_dim = dim - pose_dim;
  using PoseCovariance = Mat<S, pose_dim, pose_dim>;
  using Covariance = Mat<S, dim, dim>;

  /// The keyframe is the frame in `slot`, with its covariance in the window.
  void set_keyframe(int slot, const Covariance& covariance) {
    keyframe_ = slot;
    of_keyframe_ = covariance;
    set_keyframe_prior(covariance);
  }
  /// The factor of the next frame begins at the frame in `slot`, which becomes the keyframe: a frame that was solved
  /// alone, with its covariance (11), or one without usable image, with the covariance propagated by its factors.
  void set_reference(const auto& window, const auto& factors, int slot, const FrameSolveOptions& options) {
    if (slot == keyframe_) return;
    if (slot != latest_) return propagate_covariance(window, factors, slot, options);
    if (!has_covariance_) return;
    const PoseCovariance of_pose = transported(window, slot) + block<pose_dim, pose_dim>(relative_, 0, 0);
    of_keyframe_ = relative_;
    set_block(of_keyframe_, 0, 0, of_pose);
    set_keyframe_prior(relative_);
    keyframe_ = slot;
  }
  /// The frame in `slot` is removed from the window.
  void discard(int slot) {
    if (slot == latest_) latest_ = none;
  }

  /// Solves for the state of the frame in `slot`; false, and its state unchanged, when the rows do not determine it.
  template <class Window, class FrameFactors = NoFrameFactors>
  bool solve(const Sensors& rig, const SE3<S>& T_body_cam, const Landmarks& landmarks, Window& window,
             const auto& factors, int slot, const FrameSolveOptions& options, const FrameFactors& frame_factors = {}) {
    landmarks.for_each_with(terms_, [&](const auto& store, auto& terms) { terms.collect(store, window, T_body_cam); });
    latest_ = slot;
    const typename Window::State before = window.state(slot), keyframe_before = window.state(keyframe_);
    System system;
    DenseNormalEquations<S, pose_dim> features;
    bool features_moved = true;
    has_covariance_ = false;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      system.reset();
      if (features_moved) {
        features.reset();
        const BodyView<S> body(window.T_world_body(slot), T_body_cam);
        landmarks.for_each_with(terms_, [&](const auto&, auto& terms) { terms.accumulate(rig, body, features); });
      }
      system.add(features);
      add_weak_prior(window.state(slot).correction() - before.correction(), S(options.weak_prior_sigma), system);
      add_keyframe(window.state(keyframe_).correction() - keyframe_before.correction(), system);
      for_each_factor(window, factors, slot,
                      [&](const auto& J_i, const auto& J_j, const auto& r) { add_factor(J_i, J_j, r, system); });
      frame_factors.for_each_row(window, slot, [&](int, const auto& J, const auto& r) {
        add_frame_factor(J, r, transported(window, slot), system);
      });
      Vec<S, System::dim> d;
      if (!system.solve(d)) {
        window.state(slot) = before;
        window.state(keyframe_) = keyframe_before;
        return false;
      }
      window.state(slot).add(segment<dim>(d, 0));
      if constexpr (non_pose_dim > 0) {
        Vec<S, dim> d_keyframe = zeros<S, dim>();
        set_segment(d_keyframe, pose_dim, segment<non_pose_dim>(d, dim));
        window.state(keyframe_).add(d_keyframe);
      }
      const Vec<S, pose_dim> d_pose = segment<pose_dim>(d, 0);
      const S length = norm(d_pose);
      if (length < S(options.step_tolerance)) break;
      features_moved = !(length < S(options.linear_step));
      if (!features_moved) features.move(d_pose);
    }
    window.state(keyframe_) = keyframe_before;  // the window estimates it
    store_covariance(system);
    return true;
  }

  /// (11) of the frame in `slot` that was solved last; false when it is not defined.
  bool covariance(const auto& window, int slot, PoseCovariance& out) const {
    out = transported(window, slot) + block<pose_dim, pose_dim>(relative_, 0, 0);
    return has_covariance_;
  }

 private:
  using System = DenseNormalEquations<S, dim + non_pose_dim>;  ///< the frame, then velocity and biases of its keyframe
  using NonPose = Mat<S, non_pose_dim, non_pose_dim>;
  static constexpr int none = -1;
  /// Of velocity and biases when the keyframe has no covariance; tuned: docs/decisions/134 (chosen).
  static constexpr S fallback_sigma = S(0.1);

  /// The frame in `slot` becomes the keyframe, with the covariance that its factors propagate from the keyframe's full
  /// covariance: the uncertainty of the tilt adds to that of velocity and position.
  void propagate_covariance(const auto& window, const auto& factors, int slot, const FrameSolveOptions& options) {
    const auto L = square_root_information(of_keyframe_);
    if (!L) return;
    DenseNormalEquations<S, 2 * dim> system;  // unknowns: the frame, then its keyframe
    system.reset();
    Mat<S, dim, 2 * dim> J = zeros<S, dim, 2 * dim>();
    set_block(J, 0, dim, *L);
    system.add(J, zeros<S, dim>(), S(1));
    add_weak_prior(zeros<S, dim>(), S(options.weak_prior_sigma), system);
    for_each_factor(window, factors, slot,
                    [&]<int Rows>(const Mat<S, Rows, dim>& J_i, const Mat<S, Rows, dim>& J_j, const Vec<S, Rows>& r) {
                      Mat<S, Rows, 2 * dim> J_factor;
                      set_block(J_factor, 0, 0, J_j);
                      set_block(J_factor, 0, dim, J_i);
                      system.add(J_factor, r, S(1));
                    });
    Vec<S, 2 * dim> d;
    Mat<S, 2 * dim, 2 * dim> covariance;
    if (system.solve(d) && system.covariance(covariance)) set_keyframe(slot, block<dim, dim>(covariance, 0, 0));
  }
  /// Covariance of the frame, the pose of the keyframe being fixed.
  void store_covariance(const System& system) {
    Mat<S, System::dim, System::dim> covariance;
    has_covariance_ = system.covariance(covariance);
    if (has_covariance_) relative_ = block<dim, dim>(covariance, 0, 0);
  }

  /// Ad Sigma_pp Ad^T of (11) for the frame in `slot`.
  PoseCovariance transported(const auto& window, int slot) const {
    const PoseCovariance Ad = (window.T_world_body(slot).inverse() * window.T_world_body(keyframe_)).adjoint();
    return product_transposed(product(Ad, block<pose_dim, pose_dim>(of_keyframe_, 0, 0)), Ad);
  }
  /// Computes L of (10).
  void set_keyframe_prior(const Covariance& covariance) {
    if constexpr (non_pose_dim > 0) {
      L_non_pose_ = identity<S, non_pose_dim>() * (1 / fallback_sigma);
      Cholesky<S, pose_dim> factor;
      if (!factor.compute(block<pose_dim, pose_dim>(covariance, 0, 0), zeros<S, pose_dim>())) return;
      NonPose conditional = block<non_pose_dim, non_pose_dim>(covariance, pose_dim, pose_dim);
      for (int c = 0; c < non_pose_dim; ++c) {
        Vec<S, pose_dim> by_pose = block<pose_dim, 1>(covariance, 0, pose_dim + c);
        factor.solve_in_place(by_pose);
        for (int r = 0; r < non_pose_dim; ++r) {
          for (int k = 0; k < pose_dim; ++k) conditional(r, c) -= covariance(pose_dim + r, k) * by_pose[k];
        }
      }
      if (const auto L = square_root_information(conditional)) L_non_pose_ = *L;
    }
  }

  /// take(J_i, J_j, r) for each factor between the keyframe i and the frame j in `slot`.
  void for_each_factor(const auto& window, const auto& factors, int slot, auto&& take) const {
    factors.for_each_row(window, slot, [&](int i, const auto& J_i, int j, const auto& J_j, const auto&, const auto& r) {
      if (j == slot && i == keyframe_) take(J_i, J_j, r);
    });
  }
  template <int Rows, class T>
  static void add_factor(const Mat<T, Rows, dim>& J_i, const Mat<T, Rows, dim>& J_j, const Vec<T, Rows>& r,
                         System& system) {
    Mat<T, Rows, System::dim> J;
    set_block(J, 0, 0, J_j);
    if constexpr (non_pose_dim > 0) set_block(J, 0, dim, block<Rows, non_pose_dim>(J_i, 0, pose_dim));
    system.add(J, r, S(1));
  }

  /// Adds the rows of a factor of the frame, docs/math/factors.md (5); `of_keyframe`: Ad Sigma_pp Ad^T.
  template <int Rows, class T>
  static void add_frame_factor(const Mat<T, Rows, dim>& J, const Vec<T, Rows>& r, const PoseCovariance& of_keyframe,
                               System& system) {
    const Mat<T, Rows, pose_dim> J_pose = block<Rows, pose_dim>(J, 0, 0);
    const Mat<T, Rows, Rows> common = product_transposed(product(J_pose, of_keyframe), J_pose);
    const auto L = square_root_information(Mat<T, Rows, Rows>(identity<T, Rows>() + common));
    if (!L) return;
    Mat<T, Rows, System::dim> J_system = zeros<T, Rows, System::dim>();
    set_block(J_system, 0, 0, product(*L, J));
    system.add(J_system, times(*L, r), S(1));
  }

  /// Weak prior on velocity and biases of the frame about their predicted values.
  template <int Dim>
  static void add_weak_prior(const Vec<S, dim>& moved, S sigma, DenseNormalEquations<S, Dim>& system) {
    for (int k = pose_dim; k < dim; ++k) {
      Mat<S, 1, Dim> J = zeros<S, 1, Dim>();
      J(0, k) = 1 / sigma;
      system.add(J, Vec<S, 1>(moved[k] / sigma), S(1));
    }
  }
  /// Adds |L d_i|^2 of (10).
  void add_keyframe(const Vec<S, dim>& step, System& system) const {
    if constexpr (non_pose_dim > 0) {
      const Vec<S, non_pose_dim> moved = segment<non_pose_dim>(step, pose_dim);
      Mat<S, non_pose_dim, System::dim> J = zeros<S, non_pose_dim, System::dim>();
      set_block(J, 0, dim, L_non_pose_);
      system.add(J, product(L_non_pose_, moved), S(1));
    }
  }

  typename Landmarks::template TupleOf<MotionTerms> terms_;
  int keyframe_ = 0, latest_ = none;                  ///< slots: of the keyframe, and of the latest frame solved alone
  NonPose L_non_pose_ = identity<S, non_pose_dim>();  ///< L of (10)
  /// Sigma of (10), of the whole state of the keyframe.
  Covariance of_keyframe_ = zeros<Covariance>();
  Covariance relative_ = zeros<Covariance>();  ///< covariance of the latest frame, the keyframe's pose fixed
  bool has_covariance_ = false;
};

}  // namespace plumbline
