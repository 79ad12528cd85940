#pragma once
/// Pose refinement: the pose of one frame, landmarks fixed, by iteratively reweighted Gauss-Newton over the rows of all
/// kinds, with a gate for outliers.                             docs/math/point.md, docs/math/line.md

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

struct PoseRefinementOptions {
  int max_iterations = 10;  ///< largest number of iterations; numerics: ends by step_tolerance before
  /// Converged below this norm of an increment; the next would be about a tenth of it [rad and m];
  /// tuned: docs/decisions/084.
  double step_tolerance = 1e-4;
  double chi2_gate = 13.8;  ///< gate of an observation, squared; chi-square quantile 99.9 %, 2 degrees of freedom
  int min_inliers = 8;      ///< smallest number of inliers of a valid pose; tuned: docs/decisions/131 (chosen)
};

template <SensorRig Sensors, class Landmarks>
class PoseRefinement {
 public:
  using S = typename Sensors::Scalar;
  static constexpr int dim = state::Pose::dim;
  using Covariance = Mat<S, dim, dim>;

  explicit PoseRefinement(const PoseRefinementOptions& options) : options_(options) {}
  const PoseRefinementOptions& options() const { return options_; }

  /// Ratio of the squared errors of the last pose to their expectation, at most 1: the factor by which its covariance
  /// is too large. Larger errors have increased the sigmas already (MotionTerms::gate).
  ///                                                                                   docs/math/initialization.md (7b)
  S noise_scale2() const { return noise_scale2_; }

  /// Refines T, rejects outlier observations, and computes the covariance of T [rad, m]. `prior` is about T_predicted.
  /// Returns `none`, or the reason why there is no valid pose.
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
      const int fitting = terms.gate(store, S(options_.chi2_gate));  // by the errors before the last, short increment
      if (HasMembers<typename Store::Kind>) return;
      inliers += fitting;
      errors += S(fitting) * terms.scale2();
    });
    if (inliers < options_.min_inliers) return HealthReason::few_inliers;
    const S freedom = S(2 * inliers - dim);
    noise_scale2_ = freedom > S(0) ? std::min(S(1), 2 * errors / freedom) : S(1);
    return system.covariance(covariance) && T.is_finite() ? HealthReason::none : HealthReason::unconstrained;
  }

 private:
  /// Adds the rows T [-] T_predicted, divided by sigma.
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

  PoseRefinementOptions options_;
  S noise_scale2_ = S(1);
  typename Landmarks::template TupleOf<MotionTerms> terms_;
};

}  // namespace plumbline
