#pragma once
/// The pose of one frame with its map given: iteratively reweighted Gauss-Newton over the rows of all kinds, and a gate
/// for what does not fit.                                                          docs/math/point.md,
/// docs/math/line.md

#include <algorithm>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/motion_terms.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/residual/world_point.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/solver/gauss_newton.hpp"
#include "plumbline/state/health.hpp"
#include "plumbline/state/pose_prior.hpp"

namespace plumbline {

struct MotionOptions {
  int max_iterations = 10;
  double step_tolerance = 1e-4;  ///< converged when a step was shorter: the next is a tenth of it [rad and m]
  double chi2_gate = 13.8;       ///< 99.9 % of two degrees of freedom
  int min_inliers = 8;           ///< fewer are no estimate
};

template <SensorRig Sensors, class Landmarks>
class MotionEstimate {
 public:
  using S = typename Sensors::Scalar;
  static constexpr int dim = state::Pose::dim;
  using Covariance = Mat<S, dim, dim>;

  explicit MotionEstimate(const MotionOptions& options) : options_(options) {}
  const MotionOptions& options() const { return options_; }

  /// By how much the covariance of the last pose was too large, the errors of what it rests on being smaller than they
  /// are claimed to be. At most 1: where they are larger, less was made of them already.
  S noise_scale2() const { return noise_scale2_; }

  /// Moves T, from which the landmarks in sight are far or near, to where they agree, and takes those that do not out
  /// of the frame. `prior` is about T_predicted. `none` when all is well, else what the pose lacks.
  HealthReason refine(const Sensors& rig, const SE3<S>& T_body_cam, Landmarks& landmarks, const auto& window,
                      const SE3<S>& T_predicted, const PosePrior<S>& prior, SE3<S>& T, Covariance& covariance) {
    landmarks.for_each_with(terms_, [&](auto& store, auto& terms) { terms.collect(store, window, T_body_cam); });
    DenseNormalEquations<S, dim> system;
    for (int iteration = 0; iteration < options_.max_iterations; ++iteration) {
      system.reset();
      const BodyView<S> body(T, T_body_cam);
      landmarks.for_each_with(terms_, [&](const auto&, auto& terms) { terms.accumulate(rig, body, system); });
      if (prior.valid) add(prior, T_predicted, T, system);
      Vec<S, dim> d;
      if (!system.solve(d)) return HealthReason::unconstrained;
      T = plus(T, d);
      if (norm(d) < S(options_.step_tolerance)) break;
    }
    int inliers = 0;
    S errors = S(0);
    landmarks.for_each_with(terms_, [&]<class Store>(Store& store, auto& terms) {
      const int fitting = terms.gate(store, S(options_.chi2_gate));  // by the errors before a last, short step
      if (HoldsOthers<typename Store::Kind>) return;
      inliers += fitting;
      errors += S(fitting) * terms.scale2();
    });
    if (inliers < options_.min_inliers) return HealthReason::few_inliers;
    const S freedom = S(2 * inliers - dim);
    noise_scale2_ = freedom > S(0) ? std::min(S(1), 2 * errors / freedom) : S(1);
    return system.covariance(covariance) && T.is_finite() ? HealthReason::none : HealthReason::unconstrained;
  }

 private:
  static void add(const PosePrior<S>& prior, const SE3<S>& T_predicted, const SE3<S>& T,
                  DenseNormalEquations<S, dim>& system) {
    Vec<S, dim> weight;
    Mat<S, dim, dim> J = minus_jacobian(T, T_predicted);
    for (int k = 0; k < dim; ++k) {
      weight[k] = S(1) / prior.sigma[k];
      for (int c = 0; c < dim; ++c) J(k, c) *= weight[k];
    }
    system.add(J, cwise_product(weight, minus(T, T_predicted)), S(1));
  }

  MotionOptions options_;
  S noise_scale2_ = S(1);
  typename Landmarks::template TupleOf<MotionTerms> terms_;
};

}  // namespace plumbline
