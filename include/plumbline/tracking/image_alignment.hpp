#pragma once
/// The motion of the body between two images from small patches of known depth: sparse image alignment.
///                                                                                          docs/math/direct.md
///   r_ij(T) = I_k( pi(T_cam_body T p_i) + D_j ) - (1 + a) I_{k-1}(u_i + D_j) - b,   T = T_cur_prev of the body   (1)
///   inverse   M_i = J_pi(P_i)  R_cam_body   [-[p_i]x, I],   gradients of the previous image, once a level         (7)
///   forward   M_i = J_pi(P'_i) R_cam_body R [-[p_i]x, I],   gradients of the current image, in each iteration     (8)
///   w_i = rho'(e_i^2),   e_i = sqrt(mean_j r_ij^2) / sigma,   sigma = median of the errors on the level           (9)
///   T <- T [+] d:  R <- R Exp(dphi), p <- p + R dp
/// The inverse form is exact for zero motion and a good step for others; its last steps on the finest level are forward
/// ones when the motion is a good part of the depth. The prior and its Jacobian are those of each iteration. A gain and
/// a bias of the whole frame are estimated with it. Coarse to fine; a step that raises the cost is taken back, and a
/// coarse level that led away from the place that fits the next one better.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/assert.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/lie/plus.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/solver/cholesky.hpp"
#include "plumbline/solver/robust_loss.hpp"
#include "plumbline/tracking/alignment_patch.hpp"
#include "plumbline/tracking/increment_prior.hpp"

namespace plumbline {

struct ImageAlignmentOptions {
  int coarsest_level = 2, finest_level = 1;
  int max_iterations = 8;           ///< a level
  int forward_iterations = 3;       ///< more on the finest level, where the motion is large
  double forward_baseline = 0.05;   ///< of the depth
  double step_tolerance_px = 0.02;  ///< converged below: mean motion of the patches in the image [px of the level]
  float min_sigma_intensity = 4;    ///< of a pixel
  float independent = 0.25f;        ///< part of the pixels of a patch that err by themselves
  int min_patches = 10;
};

/// A place in the previous image and where it is in space.
template <std::floating_point S>
struct AlignmentSample {
  Vec<float, 2> pixel;  ///< in the previous image [px]
  Vec<float, 2> shift;  ///< from where the camera model sees a point to where the current image shows it [px]
  Vec<S, 3> p_body;     ///< in the previous body [m]
  float weight = 1;
};

template <std::floating_point S>
struct ImageAlignment {
  bool valid = false;
  SE3<S> T_cur_prev;                           ///< of the body
  Mat<S, 6, 6> covariance = zeros<S, 6, 6>();  ///< of its increment [dphi, dp]
  float gain = 0, bias = 0;                    ///< a, b of (1)
  float sigma_intensity = 0;                   ///< of the patches' errors on the finest level
  int patches = 0;                             ///< that took part there
};

template <CameraModel Camera>
class ImageAligner {
 public:
  using S = typename Camera::Scalar;
  using Levels = std::span<const ImageView<const std::uint8_t>>;
  using Samples = std::span<const AlignmentSample<S>>;

  /// `scratch` and `errors` are as long as `samples`. `T_cur_prev`: where the search begins.
  ImageAligner(const Camera& camera, const SE3<S>& T_body_cam, Samples samples, std::span<AlignmentPatch> scratch,
               std::span<float> errors, const ImageAlignmentOptions& options)
      : camera_(camera),
        T_cam_body_(T_body_cam.inverse()),
        samples_(samples),
        patches_(scratch.first(samples.size())),
        errors_(errors.first(samples.size())),
        options_(options) {}

  ImageAlignment<S> align(Levels previous, Levels current, const IncrementPrior<S>& prior, const SE3<S>& T_cur_prev) {
    ImageAlignment<S> out;
    out.T_cur_prev = T_cur_prev;
    const int coarsest = std::min(options_.coarsest_level, int(previous.size()) - 1);
    for (int level = coarsest; level >= options_.finest_level; --level) {
      const auto& image = current[std::size_t(level)];
      capture(previous[std::size_t(level)], level);
      if (level < coarsest) begin_at_better(image, level, prior, T_cur_prev, out);
      out.valid = iterate(image, level, false, options_.max_iterations, prior, out);
    }
    if (out.valid && is_large(out.T_cur_prev)) {
      out.valid = iterate(current[std::size_t(options_.finest_level)], options_.finest_level, true,
                          options_.forward_iterations, prior, out);
    }
    out.valid = out.valid && out.T_cur_prev.is_finite();
    return out;
  }

 private:
  static constexpr int dim = 8;  ///< dphi, dp, a, b
  struct System {
    Mat<S, dim, dim> H = zeros<S, dim, dim>();  ///< upper triangle, then all of it
    Vec<S, dim> b = zeros<S, dim>();
    S cost = S(0);  ///< mean over the patches, the prior's part included
    int patches = 0;
  };

  /// Templates, gradients and the inverse form's Jacobians.
  void capture(const ImageView<const std::uint8_t>& image, int level) {
    const S scale = S(1) / S(1 << level);
    const Mat<S, 3, 3> R_cam_body = T_cam_body_.R();
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      AlignmentPatch& patch = patches_[i];
      patch.capture(image, to_level(samples_[i].pixel, level));
      if (patch.valid) patch.valid = set_jacobian(patch, T_cam_body_ * samples_[i].p_body, R_cam_body, i, scale);
    }
  }
  /// M of (7), (8).
  bool set_jacobian(AlignmentPatch& patch, const Vec<S, 3>& p_cam, const Mat<S, 3, 3>& R_cam_prev, std::size_t i,
                    S scale) const {
    const Projection<S> projection = camera_.project(p_cam);
    if (!projection.valid) return false;
    set_jacobian(patch, projection, R_cam_prev, i, scale);
    return true;
  }
  void set_jacobian(AlignmentPatch& patch, const Projection<S>& projection, const Mat<S, 3, 3>& R_cam_prev,
                    std::size_t i, S scale) const {
    const Mat<S, 2, 6> M = motion_jacobian(projection.J_uv_p, R_cam_prev, samples_[i].p_body);
    for (int c = 0; c < 6; ++c) {
      for (int k = 0; k < 2; ++k) patch.M(k, c) = float(scale * M(k, c));
    }
  }

  /// Coarse pixels may lead astray: the next level begins where they led, or where the search began, if that fits
  /// better.
  void begin_at_better(const ImageView<const std::uint8_t>& image, int level, const IncrementPrior<S>& prior,
                       const SE3<S>& T_first, ImageAlignment<S>& out) {
    ImageAlignment<S> first = out;
    first.T_cur_prev = T_first;
    const auto cost_of = [&](ImageAlignment<S>& at, bool scale) {
      compare(image, level, at, false);
      if (scale) first.sigma_intensity = out.sigma_intensity = scale_of_errors();
      System system;
      accumulate(at, prior, system);
      return system.patches < options_.min_patches ? std::numeric_limits<S>::infinity() : system.cost;
    };
    const S cost = cost_of(out, true);
    if (!(cost <= cost_of(first, false))) out = first;
  }

  /// Iterates from `out`; false when too few patches are seen or they do not determine the motion.
  bool iterate(const ImageView<const std::uint8_t>& image, int level, bool forward, int max_iterations,
               const IncrementPrior<S>& prior, ImageAlignment<S>& out) {
    ImageAlignment<S> now = out;
    S best_cost = S(-1);
    for (int iteration = 0; iteration < max_iterations; ++iteration) {
      compare(image, level, now, forward);
      if (iteration == 0) now.sigma_intensity = scale_of_errors();
      System system;
      accumulate(now, prior, system);
      if (system.patches < options_.min_patches) return false;
      if (iteration > 0 && !(system.cost <= best_cost)) break;  // false for NaN, too; `out` is the one before
      best_cost = system.cost;
      now.patches = system.patches;
      out = now;
      Cholesky<S, dim> factor;
      if (!factor.compute(system.H, zeros<S, dim>())) return false;
      Vec<S, dim> d = -system.b;
      factor.solve_in_place(d);
      if (!all_finite(d)) return false;
      set_covariance(factor, now);
      now.T_cur_prev = plus(now.T_cur_prev, segment<6>(d, 0));
      now.gain += float(d[6]);
      now.bias += float(d[7]);
      out.covariance = now.covariance;
      if (iteration + 1 < max_iterations && !(mean_motion_px(d) < S(options_.step_tolerance_px))) continue;
      out = now;
      break;
    }
    return true;
  }

  /// Residuals of all patches at `now`.
  void compare(const ImageView<const std::uint8_t>& image, int level, const ImageAlignment<S>& now, bool forward) {
    const SE3<S> T_cam_prev = T_cam_body_ * now.T_cur_prev;
    const Mat<S, 3, 3> R_cam_prev = T_cam_prev.R();
    const S scale = S(1) / S(1 << level);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      AlignmentPatch& patch = patches_[i];
      patch.visible = false;
      if (!patch.valid) continue;
      const Projection<S> projection = camera_.project(R_cam_prev * samples_[i].p_body + T_cam_prev.p());
      if (!projection.valid) continue;
      const Vec<float, 2> uv = cast_to<float>(projection.uv) + samples_[i].shift;
      patch.compare(image, to_level(uv, level), now.gain, now.bias, forward);
      if (forward && patch.visible) set_jacobian(patch, projection, R_cam_prev, i, scale);
    }
  }

  /// sigma of (9).
  float scale_of_errors() {
    std::size_t n = 0;
    for (const AlignmentPatch& patch : patches_) {
      if (patch.visible) errors_[n++] = patch.error;
    }
    if (n == 0) return options_.min_sigma_intensity;
    const auto middle = errors_.begin() + std::ptrdiff_t(n / 2);
    std::nth_element(errors_.begin(), middle, errors_.begin() + std::ptrdiff_t(n));
    return std::max(options_.min_sigma_intensity, *middle);
  }

  void accumulate(const ImageAlignment<S>& now, const IncrementPrior<S>& prior, System& system) const {
    const GemanMcClure<float> loss{4};
    const float sigma = now.sigma_intensity;
    const float information = options_.independent / (sigma * sigma);
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      const AlignmentPatch& patch = patches_[i];
      if (!patch.visible) continue;
      const float e = patch.error / sigma, weight = samples_[i].weight * loss.weight(e * e);
      patch.add_to(system, now.gain, information * weight);
      system.cost += S(samples_[i].weight * loss.rho(e * e));
      ++system.patches;
    }
    if (prior.valid) {
      const auto prior_rows = prior.linearize(now.T_cur_prev);
      for (int j = 0; j < 6; ++j) {
        for (int k = 0; k < 6; ++k) {
          for (int i = 0; i <= j; ++i) system.H(i, j) += prior_rows.J(k, i) * prior_rows.J(k, j);
          system.b[j] += prior_rows.J(k, j) * prior_rows.r[k];
        }
      }
      const S pixels = S(options_.independent * float(AlignmentPatch::samples));
      system.cost += squared_norm(prior_rows.r) / pixels;
    }
    for (int k = 6; k < dim; ++k) system.H(k, k) += brightness_information(k);
    for (int j = 0; j < dim; ++j) {
      for (int i = 0; i < j; ++i) system.H(j, i) = system.H(i, j);
    }
    if (system.patches > 0) system.cost /= S(system.patches);
  }
  /// In a frame without contrast gain and bias cannot be separated: both are near zero, then.
  static S brightness_information(int k) {
    constexpr S sigma_gain = S(1), sigma_bias = S(50);
    return k == 6 ? 1 / (sigma_gain * sigma_gain) : 1 / (sigma_bias * sigma_bias);
  }

  /// The motion is a good part of the depth.
  bool is_large(const SE3<S>& T_cur_prev) const {
    S inverse_range = S(0);
    int n = 0;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      if (!patches_[i].visible) continue;
      inverse_range += 1 / norm(samples_[i].p_body);
      ++n;
    }
    return n > 0 && norm(T_cur_prev.p()) * inverse_range > S(options_.forward_baseline) * S(n);
  }

  S mean_motion_px(const Vec<S, dim>& d) const {
    float sum = 0;
    int n = 0;
    const Vec<float, 6> step = cast_to<float>(segment<6>(d, 0));
    for (const AlignmentPatch& patch : patches_) {
      if (!patch.visible) continue;
      sum += std::abs(patch.M.row(0).dot(step)) + std::abs(patch.M.row(1).dot(step));
      ++n;
    }
    return n > 0 ? S(sum) / S(n) : S(0);
  }

  static void set_covariance(const Cholesky<S, dim>& factor, ImageAlignment<S>& out) {
    for (int c = 0; c < 6; ++c) {
      Vec<S, dim> column = zeros<S, dim>();
      column[c] = S(1);
      factor.solve_in_place(column);
      for (int k = 0; k < 6; ++k) out.covariance(k, c) = column[k];
    }
  }

  const Camera& camera_;
  SE3<S> T_cam_body_;
  Samples samples_;
  std::span<AlignmentPatch> patches_;
  std::span<float> errors_;
  const ImageAlignmentOptions& options_;
};

}  // namespace plumbline
