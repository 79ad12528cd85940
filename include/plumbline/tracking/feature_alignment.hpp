#pragma once
/// Alignment of a landmark's reference patch in the current image under a known affine warp.  docs/math/tracking.md
///
///   lambda(u_r + d) = lambda (1 + a^T d)                   inverse range of the surface around the feature     (6)
///   A_cr(a) = du_c/du_r = J_pi,c R_c_r range (J_b - b a^T)                                                     (7)
///           = A_cr - e a^T,  e = J_pi,c R_c_r range b                                                          (7a)
///   l         = smallest level with det(A_cr) / 4^l <= 3;  rejected: det <= 0.05, det > 25, cond(A_cr) > 8     (8)
///   T_j       = I_r(u_r + A_cr^-1 D_j 2^l),  D_j in pixels of the search level l                               (9)
///   n_c       = A_cr^-T n_r / |.|                                an edge normal is a covector                 (10)
///   H         = J^T J - n s^2/2 I                                n pixels of noise s alone look like texture (10a)
/// Gradients are those of the WARPED template: they are in the axes of the current image.

#include <algorithm>
#include <cmath>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/tracking/patch_template.hpp"
#include "plumbline/tracking/reference_patch.hpp"

namespace plumbline {

struct AlignmentOptions {
  int max_iterations = 15;
  float epsilon_px = 0.02f;     ///< [px of the search level]
  float max_move_px = 4.0f;     ///< farthest from the guess [px of the search level]
  float min_eigenvalue = 0.5f;  ///< texture per pixel [intensity^2/px^2]; along the normal for edges
  float max_rms = 20.0f;        ///< intensity residual after gain and bias
  float min_gain = 0.5f, max_gain = 2.0f;
  float image_noise = 2;      ///< s of (10a) on level 0, half of it on each next one [intensity]
  bool coarse_start = false;  ///< search one level higher first: for guesses wrong by more than 2..3 px
};

struct Alignment {
  bool valid;
  Vec<float, 2> uv;  ///< [px] of level 0
  int level;         ///< where it was measured: its pixel is 2^level px wide
  float rms;         ///< intensity residual
  /// (10a) of the position, gain and bias eliminated, in pixels of level 0; times 1/sigma_intensity^2 it is the
  /// information of uv. Rank one for edges.
  Mat<float, 2, 2> information_per_intensity;
};

/// Of a surface around a feature: how its pixels move from one image to another.
struct AffineWarp {
  Mat<float, 2, 2> A_cur_ref;  ///< (7) where all of it is equally far; the zero matrix where it is not defined
  Vec<float, 2> by_slant;      ///< e of (7a) [px]

  /// With the inverse range of (6).
  Mat<float, 2, 2> slanted(const Vec<float, 2>& a) const { return A_cur_ref - by_slant * a.transpose(); }
};

/// bearing_ref: unit bearing of the feature in the reference camera; range: |X_r| [m]. T_cur_ref maps reference camera
/// coordinates into the current camera. A_cur_ref that is not defined is rejected by `search_level`.
template <CameraModel Camera>
AffineWarp affine_warp(const Camera& camera_ref, const Camera& camera_cur,
                       const Vec<typename Camera::Scalar, 3>& bearing_ref, typename Camera::Scalar range,
                       const SE3<typename Camera::Scalar>& T_cur_ref) {
  using S = typename Camera::Scalar;
  AffineWarp out{zeros<float, 2, 2>(), zeros<float, 2>()};
  const Projection<S> reference = camera_ref.project(bearing_ref);
  const Projection<S> current = camera_cur.project(T_cur_ref * Vec<S, 3>(range * bearing_ref));
  if (!reference.valid || !current.valid) return out;
  const Mat<S, 3, 2> J_b_uv = bearing_jacobian(reference.J_uv_p);
  const auto moved = [&](const Vec<S, 3>& db) {
    return cast_to<float>(product(current.J_uv_p, Vec<S, 3>(T_cur_ref.rotation() * Vec<S, 3>(range * db))));
  };
  for (int k = 0; k < 2; ++k) set_block(out.A_cur_ref, 0, k, moved(block<3, 1>(J_b_uv, 0, k)));
  out.by_slant = moved(bearing_ref);
  return out;
}

/// The search level of (8), at most `max_level`; -1 when the warp is rejected (NaN too).
inline int search_level(const Mat<float, 2, 2>& A_cur_ref, int max_level) {
  constexpr float min_det = 0.05f, max_det = 25.0f, max_condition = 8.0f, max_level_det = 3.0f;
  float det = A_cur_ref(0, 0) * A_cur_ref(1, 1) - A_cur_ref(0, 1) * A_cur_ref(1, 0);
  if (!(det > min_det && det <= max_det)) return -1;
  // s1^2 + s2^2 = |A|_F^2 and s1 s2 = det: s1/s2 <= c  <=>  |A|_F^2 <= (c + 1/c) det
  if (!(squared_norm(A_cur_ref) <= (max_condition + 1.0f / max_condition) * det)) return -1;
  int level = 0;
  for (; level < max_level && det > max_level_det; ++level) det /= 4.0f;
  return level;
}

/// The unit normal of an edge in the current image from the one in the reference image.                         (10)
inline Vec<float, 2> edge_normal(const Mat<float, 2, 2>& A_cur_ref, const Vec<float, 2>& n_ref) {
  // A^-T is the cofactor matrix over det(A), and det(A) > 0
  return Vec<float, 2>(A_cur_ref(1, 1) * n_ref.x() - A_cur_ref(1, 0) * n_ref.y(),
                       A_cur_ref(0, 0) * n_ref.y() - A_cur_ref(0, 1) * n_ref.x())
      .normalized();
}

/// The warped template (9) for search level `level`, sampled where one step is about one pixel of the reference.
/// False when no held level covers it.
template <int PatchSize, class Reference>
bool warp_template(const Reference& reference, const Mat<float, 2, 2>& A_cur_ref, int level, Patch<PatchSize>& out) {
  const float det = A_cur_ref(0, 0) * A_cur_ref(1, 1) - A_cur_ref(0, 1) * A_cur_ref(1, 0);
  Mat<float, 2, 2> A_step;  // offsets of the search level to pixels of reference level m
  A_step << A_cur_ref(1, 1), -A_cur_ref(0, 1), -A_cur_ref(1, 0), A_cur_ref(0, 0);
  A_step *= static_cast<float>(1 << level) / det;
  constexpr float max_step_det = 3.0f;
  for (int m = 0; m < reference.levels(); ++m, A_step *= 0.5f) {
    const float step_det = A_step(0, 0) * A_step(1, 1) - A_step(0, 1) * A_step(1, 0);
    if (step_det > max_step_det && m + 1 < reference.levels()) continue;
    if (interpolate_warped_patch<PatchSize>(reference.level(m), reference.center(m), A_step, out)) return true;
  }
  return false;
}

/// (10a), `noise` = n s^2/2; its eigenvalues are at least a hundredth of that.
inline Mat<float, 2, 2> without_noise(const Mat<float, 2, 2>& JtJ, float noise) {
  const float mean = 0.5f * (JtJ(0, 0) + JtJ(1, 1)), half_difference = 0.5f * (JtJ(0, 0) - JtJ(1, 1));
  const float half_gap = std::sqrt(half_difference * half_difference + JtJ(0, 1) * JtJ(0, 1));
  const auto left = [noise](float eigenvalue) { return std::max(eigenvalue - noise, 0.01f * noise); };
  const float largest = left(mean + half_gap), least = left(mean - half_gap);
  const float stretch = half_gap > 0 ? 0.5f * (largest - least) / half_gap : 0.0f, middle = 0.5f * (largest + least);
  Mat<float, 2, 2> H;
  H(0, 0) = middle + stretch * half_difference;
  H(1, 1) = middle - stretch * half_difference;
  H(0, 1) = H(1, 0) = stretch * JtJ(0, 1);
  return H;
}

/// Shared by points and edges: `n` null aligns both components, else the one along the unit normal *n.
template <int PatchSize, class Reference, class Pyr>
Alignment align_on_level(const Reference& reference, const Mat<float, 2, 2>& A_cur_ref, const Pyr& current,
                         const Vec<float, 2>& uv_guess, const Vec<float, 2>* n, int level,
                         const AlignmentOptions& options) {
  using Template = PatchTemplate<PatchSize>;
  Alignment out{false, uv_guess, level, 0.0f, zeros<float, 2, 2>()};
  typename Template::Bordered bordered;
  if (!warp_template<Template::bordered_size>(reference, A_cur_ref, level, bordered)) return out;
  Template patch;
  patch.set(bordered, n == nullptr);
  const Mat<float, 2, 2>& H = patch.information();
  const float texture =
      n == nullptr ? patch.min_eigenvalue() : dot(*n, H * *n) / static_cast<float>(PatchSize * PatchSize);
  if (!(texture > options.min_eigenvalue)) return out;
  const PatchSearch bounds{options.max_iterations, options.epsilon_px, options.max_move_px};
  const Vec<float, 2> start = to_level(uv_guess, level);
  const PatchMatch match = n == nullptr ? patch.search(current.level(level), start, bounds)
                                        : patch.search_along(current.level(level), start, *n, bounds);
  out.uv = from_level(match.uv, level);
  out.rms = match.rms;
  out.valid =
      match.valid && match.rms < options.max_rms && match.gain > options.min_gain && match.gain < options.max_gain;
  const float scale = match.gain / static_cast<float>(1 << level);
  const float noise = options.image_noise / static_cast<float>(1 << level);
  constexpr float half_pixels = 0.5f * PatchSize * PatchSize;
  out.information_per_intensity = scale * scale * without_noise(H, half_pixels * noise * noise);
  if (n != nullptr) out.information_per_intensity = (scale * scale * dot(*n, H * *n)) * *n * n->transpose();
  return out;
}

/// Chooses the level, searches one level higher first when asked, then aligns.
template <int PatchSize, class Reference, class Pyr>
Alignment align_from_coarse(const Reference& reference, const Mat<float, 2, 2>& A_cur_ref, const Pyr& current,
                            const Vec<float, 2>& uv_guess, const Vec<float, 2>* n, const AlignmentOptions& options) {
  const int level = search_level(A_cur_ref, Pyr::levels - 1);
  if (level < 0 || reference.levels() == 0) return {false, uv_guess, 0, 0.0f, zeros<float, 2, 2>()};
  Vec<float, 2> start = uv_guess;
  if (options.coarse_start && level + 1 < Pyr::levels) {
    const Alignment coarse = align_on_level<PatchSize>(reference, A_cur_ref, current, start, n, level + 1, options);
    if (coarse.valid) start = coarse.uv;
  }
  return align_on_level<PatchSize>(reference, A_cur_ref, current, start, n, level, options);
}

/// Aligns both components of the position. `uv_guess` and the result are pixels of level 0 of the current image.
template <int PatchSize = 10, class Reference, class Pyr>
Alignment align_patch(const Reference& reference, const Mat<float, 2, 2>& A_cur_ref, const Pyr& current,
                      const Vec<float, 2>& uv_guess, const AlignmentOptions& options) {
  return align_from_coarse<PatchSize>(reference, A_cur_ref, current, uv_guess, nullptr, options);
}

/// Aligns along the unit normal `n_cur` (10) of an edge alone, with bias and without gain; the other component of the
/// result is the guess's and measures nothing.
template <int PatchSize = 10, class Reference, class Pyr>
Alignment align_edge(const Reference& reference, const Mat<float, 2, 2>& A_cur_ref, const Pyr& current,
                     const Vec<float, 2>& uv_guess, const Vec<float, 2>& n_cur, const AlignmentOptions& options) {
  return align_from_coarse<PatchSize>(reference, A_cur_ref, current, uv_guess, &n_cur, options);
}

}  // namespace plumbline
