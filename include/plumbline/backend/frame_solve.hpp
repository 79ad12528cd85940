#pragma once
/// The newest frame alone, its map being given, together with what the window left open of its keyframe: Gauss-Newton
/// over the rows of its features and of its links.                                           docs/math/direct.md
///
///   landmarks are given with their own uncertainty, as in the estimate of the pose (feature/motion_terms.hpp)
///   unknown: the frame's state and, the pose of keyframe i being given, the rest of x_i (velocity, biases)
///   |L d_i|^2         ,   (L^T L)^-1 = Sigma_rr - Sigma_rp Sigma_pp^-1 Sigma_pr                                (10)
///                         from the window's covariance of the keyframe, p its pose, r the rest
///   Sigma_j = Ad Sigma_pp Ad^T + Sigma_relative   of the frame's pose, Ad = Ad(T_world_j^-1 T_world_i)         (11)
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
  double linear_step = 2e-3;     ///< features are linear in a shorter one [rad and m]
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

  /// The keyframe in `slot` with its covariance in the window.
  void set_keyframe(int slot, const Covariance& covariance) {
    keyframe_ = slot;
    of_keyframe_ = covariance;
    set_rest(covariance);
  }
  /// The next frame hangs on the one in `slot`: a frame that was solved alone may stay, and be the keyframe; so may one
  /// that no image told of, where its links led.
  void follow(const auto& window, const auto& links, int slot, const FrameSolveOptions& options) {
    if (slot == keyframe_) return;
    if (slot != latest_) return lead(window, links, slot, options);
    if (!known_) return;
    const PoseCovariance of_pose = carried(window, slot) + block<pose_dim, pose_dim>(relative_, 0, 0);
    of_keyframe_ = relative_;
    set_block(of_keyframe_, 0, 0, of_pose);
    set_rest(relative_);
    keyframe_ = slot;
  }
  /// The frame in `slot` goes.
  void forget(int slot) {
    if (slot == latest_) latest_ = none;
  }

  /// Moves the state of the frame in `slot`; false, and nothing moved, when the rows do not determine it.
  template <class Window>
  bool solve(const Sensors& rig, const SE3<S>& T_body_cam, const Landmarks& landmarks, Window& window,
             const auto& links, int slot, const FrameSolveOptions& options) {
    landmarks.for_each_with(terms_, [&](const auto& store, auto& terms) { terms.collect(store, window, T_body_cam); });
    latest_ = slot;
    const typename Window::State before = window.state(slot), keyframe_before = window.state(keyframe_);
    System system;
    DenseNormalEquations<S, pose_dim> features;
    bool features_moved = true;
    known_ = false;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      system.reset();
      if (features_moved) {
        features.reset();
        const BodyView<S> body(window.T_world_body(slot), T_body_cam);
        landmarks.for_each_with(terms_, [&](const auto&, auto& terms) { terms.accumulate(rig, body, features); });
      }
      system.add(features);
      add_rest(window.state(slot).correction() - before.correction(), S(options.sigma_rest), system);
      add_keyframe(window.state(keyframe_).correction() - keyframe_before.correction(), system);
      for_each_link(window, links, slot,
                    [&](const auto& J_i, const auto& J_j, const auto& r) { add_link(J_i, J_j, r, system); });
      Vec<S, System::dim> d;
      if (!system.solve(d)) {
        window.state(slot) = before;
        window.state(keyframe_) = keyframe_before;
        return false;
      }
      window.state(slot).add(segment<dim>(d, 0));
      if constexpr (rest_dim > 0) {
        Vec<S, dim> d_keyframe = zeros<S, dim>();
        set_segment(d_keyframe, pose_dim, segment<rest_dim>(d, dim));
        window.state(keyframe_).add(d_keyframe);
      }
      const Vec<S, pose_dim> d_pose = segment<pose_dim>(d, 0);
      const S length = norm(d_pose);
      if (length < S(options.step_tolerance)) break;
      features_moved = !(length < S(options.linear_step));
      if (!features_moved) features.move(d_pose);
    }
    window.state(keyframe_) = keyframe_before;  // it is the window's
    know(system);
    return true;
  }

  /// (11) of the frame in `slot` that was solved last; false when it is not defined.
  bool covariance(const auto& window, int slot, PoseCovariance& out) const {
    out = carried(window, slot) + block<pose_dim, pose_dim>(relative_, 0, 0);
    return known_;
  }

 private:
  using System = DenseNormalEquations<S, dim + rest_dim>;  ///< the frame, then the rest of its keyframe
  using Rest = Mat<S, rest_dim, rest_dim>;
  static constexpr int none = -1;
  static constexpr S fallback_sigma = S(0.1);  ///< where the window does not know the keyframe

  /// The frame in `slot` is known as far as its links lead from the keyframe, whose pose is in doubt, too: what leans
  /// falls elsewhere.
  void lead(const auto& window, const auto& links, int slot, const FrameSolveOptions& options) {
    const auto L = square_root_information(of_keyframe_);
    if (!L) return;
    DenseNormalEquations<S, 2 * dim> system;  // the frame, then its keyframe
    system.reset();
    Mat<S, dim, 2 * dim> J = zeros<S, dim, 2 * dim>();
    set_block(J, 0, dim, *L);
    system.add(J, zeros<S, dim>(), S(1));
    add_rest(zeros<S, dim>(), S(options.sigma_rest), system);
    for_each_link(window, links, slot,
                  [&]<int Rows>(const Mat<S, Rows, dim>& J_i, const Mat<S, Rows, dim>& J_j, const Vec<S, Rows>& r) {
                    Mat<S, Rows, 2 * dim> J_link;
                    set_block(J_link, 0, 0, J_j);
                    set_block(J_link, 0, dim, J_i);
                    system.add(J_link, r, S(1));
                  });
    Vec<S, 2 * dim> d;
    Mat<S, 2 * dim, 2 * dim> covariance;
    if (system.solve(d) && system.covariance(covariance)) set_keyframe(slot, block<dim, dim>(covariance, 0, 0));
  }
  void know(const System& system) {
    Mat<S, System::dim, System::dim> covariance;
    known_ = system.covariance(covariance);
    if (known_) relative_ = block<dim, dim>(covariance, 0, 0);
  }

  /// The keyframe's pose covariance as one of the frame in `slot`.
  PoseCovariance carried(const auto& window, int slot) const {
    const PoseCovariance Ad = (window.T_world_body(slot).inverse() * window.T_world_body(keyframe_)).adjoint();
    return product_transposed(product(Ad, block<pose_dim, pose_dim>(of_keyframe_, 0, 0)), Ad);
  }
  /// (10)
  void set_rest(const Covariance& covariance) {
    if constexpr (rest_dim > 0) {
      L_rest_ = identity<S, rest_dim>() * (1 / fallback_sigma);
      Cholesky<S, pose_dim> factor;
      if (!factor.compute(block<pose_dim, pose_dim>(covariance, 0, 0), zeros<S, pose_dim>())) return;
      Rest conditional = block<rest_dim, rest_dim>(covariance, pose_dim, pose_dim);
      for (int c = 0; c < rest_dim; ++c) {
        Vec<S, pose_dim> by_pose = block<pose_dim, 1>(covariance, 0, pose_dim + c);
        factor.solve_in_place(by_pose);
        for (int r = 0; r < rest_dim; ++r) {
          for (int k = 0; k < pose_dim; ++k) conditional(r, c) -= covariance(pose_dim + r, k) * by_pose[k];
        }
      }
      if (const auto L = square_root_information(conditional)) L_rest_ = *L;
    }
  }

  /// take(J_i, J_j, r) of what ties the frame in `slot` to the keyframe.
  void for_each_link(const auto& window, const auto& links, int slot, auto&& take) const {
    links.for_each_row(window, slot, [&](int i, const auto& J_i, int j, const auto& J_j, const auto&, const auto& r) {
      if (j == slot && i == keyframe_) take(J_i, J_j, r);
    });
  }
  template <int Rows, class T>
  static void add_link(const Mat<T, Rows, dim>& J_i, const Mat<T, Rows, dim>& J_j, const Vec<T, Rows>& r,
                       System& system) {
    Mat<T, Rows, System::dim> J;
    set_block(J, 0, 0, J_j);
    if constexpr (rest_dim > 0) set_block(J, 0, dim, block<Rows, rest_dim>(J_i, 0, pose_dim));
    system.add(J, r, S(1));
  }

  /// Keeps the frame's velocity and biases near to what was predicted, where nothing else does.
  template <int Dim>
  static void add_rest(const Vec<S, dim>& moved, S sigma, DenseNormalEquations<S, Dim>& system) {
    for (int k = pose_dim; k < dim; ++k) {
      Mat<S, 1, Dim> J = zeros<S, 1, Dim>();
      J(0, k) = 1 / sigma;
      system.add(J, Vec<S, 1>(moved[k] / sigma), S(1));
    }
  }
  /// (10)
  void add_keyframe(const Vec<S, dim>& step, System& system) const {
    if constexpr (rest_dim > 0) {
      const Vec<S, rest_dim> moved = segment<rest_dim>(step, pose_dim);
      Mat<S, rest_dim, System::dim> J = zeros<S, rest_dim, System::dim>();
      set_block(J, 0, dim, L_rest_);
      system.add(J, product(L_rest_, moved), S(1));
    }
  }

  typename Landmarks::template TupleOf<MotionTerms> terms_;
  int keyframe_ = 0, latest_ = none;       ///< slots; the latest that was solved alone
  Rest L_rest_ = identity<S, rest_dim>();  ///< L of (10)
  Covariance of_keyframe_ = zeros<Covariance>();
  Covariance relative_ = zeros<Covariance>();  ///< of the latest, the keyframe's pose being given
  bool known_ = false;
};

}  // namespace plumbline
