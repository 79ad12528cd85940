#pragma once
/// How the surface around a point slants away from the camera that saw it first, estimated while its pixels are
/// followed: no sensor of depth is needed.                                                    docs/math/tracking.md
///
///   lambda(u_r + d) = lambda (1 + a^T d)                  inverse range over the reference's pixels             (6)
///   S_j = dT_j/da   = (grad T_j . e) (A_cr^-1 D_j)^T      T: the warped template, e of (7a)                     (9a)
///   H = g^2 S^T P S,   h = g S^T P I                      P: free of 1, T and grad T: bias, gain g, position    (9b)
///   Lambda <- Lambda + H / s^2,   a <- a + (Lambda + Lambda_0)^-1 h / s^2,   Lambda_0 = (f / t_0)^2             (9c)
/// s: noise of a pixel; f [px]; t_0: tangent of the angle between normal and bearing that is expected. Views from far
/// aside have the most information, since e grows with the parallax.

#include <algorithm>
#include <array>
#include <cmath>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/patch.hpp"
#include "plumbline/image/patch_sums.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/reference_patch.hpp"

namespace plumbline {

struct SlantOptions {
  float sigma_tangent = 0.7f;  ///< t_0, of the angle between the surface's normal and the bearing
  float max_tangent = 2;       ///< steeper surfaces are taken for one of that
  float sigma_intensity = 16;  ///< s, correlated errors of a whole patch included
  float max_rms = 20;          ///< of the intensities that no slant explains
};

/// The equation of one view for a change da of the slant: H da = h.                                             (9b)
struct SlantEquations {
  bool valid = false;
  Mat<float, 2, 2> H = zeros<float, 2, 2>();  ///< [intensity^2 px^2]
  Vec<float, 2> h = zeros<float, 2>();        ///< [intensity^2 px]
  float rms = 0;                              ///< of the intensities [intensity]
};

/// (9b), about `slant`, where `uv` [px of level 0] is the place of the reference in the current image.
template <int PatchSize = 10, class Pyr>
SlantEquations slant_equations(const ReferencePatch& reference, const AffineWarp& warp, const Vec<float, 2>& slant,
                               const Pyr& current, const Vec<float, 2>& uv) {
  constexpr int bordered_size = PatchSize + 2, n = PatchSize * PatchSize;
  SlantEquations out;
  const Mat<float, 2, 2> A = warp.slanted(slant);
  const int level = search_level(A, Pyr::levels - 1);
  if (level < 0 || reference.levels() == 0) return out;
  const float scale = static_cast<float>(1 << level);
  const Vec<float, 2> at = to_level(uv, level), e = warp.by_slant / scale;
  Patch<bordered_size> bordered;
  if (!patch_inside(current.level(level), at, PatchSize) ||
      !warp_template<bordered_size>(reference, A, level, bordered))
    return out;
  Mat<float, 2, 2> A_inverse;
  if (!invert(A, A_inverse)) return out;

  enum : int { warped, gradient_x, gradient_y, slant_x, slant_y, image, columns };
  std::array<Patch<PatchSize>, columns> column;
  interpolate_patch<PatchSize>(current.level(level), at, column[image]);
  for (int y = 0, k = 0; y < PatchSize; ++y) {
    const float* row = bordered.data() + (y + 1) * bordered_size + 1;
    for (int x = 0; x < PatchSize; ++x, ++k) {
      const Vec<float, 2> gradient(0.5f * (row[x + 1] - row[x - 1]),
                                   0.5f * (row[x + bordered_size] - row[x - bordered_size]));
      constexpr float middle = 0.5f * (PatchSize - 1);
      const Vec<float, 2> D(static_cast<float>(x) - middle, static_cast<float>(y) - middle);
      const Vec<float, 2> S = (scale * dot(gradient, e)) * (A_inverse * D);
      column[warped][k] = row[x];
      column[gradient_x][k] = gradient.x();
      column[gradient_y][k] = gradient.y();
      column[slant_x][k] = S.x();
      column[slant_y][k] = S.y();
    }
  }
  for (Patch<PatchSize>& each : column) {
    const float mean = mean_of(each);
    for (int k = 0; k < n; ++k) each[k] -= mean;
  }
  Mat<float, columns, columns> G;
  for (int i = 0; i < columns; ++i) {
    for (int k = 0; k <= i; ++k) G(i, k) = G(k, i) = sum_of_products(column[i], column[k]);
  }
  const float gain = G(warped, image) / G(warped, warped);
  for (int pivot = 0; pivot < slant_x; ++pivot) {
    constexpr float least = n;  // what quantization alone amounts to [intensity^2]
    if (!(G(pivot, pivot) > least)) return out;
    for (int i = pivot + 1; i < columns; ++i) {
      const float factor = G(i, pivot) / G(pivot, pivot);
      for (int k = pivot + 1; k < columns; ++k) G(i, k) -= factor * G(pivot, k);
    }
  }
  out.H = (gain * gain) * block<2, 2>(G, slant_x, slant_x);
  out.h = gain * block<2, 1>(G, slant_x, image);
  out.rms = std::sqrt(std::max(G(image, image), 0.0f) / n);
  out.valid = all_finite(out.H) && all_finite(out.h);
  return out;
}

/// What all views have said.
class SurfaceSlant {
 public:
  const Vec<float, 2>& a() const { return a_; }  ///< of (6) [1/px]

  /// One more of them; f: pixels a radian where the reference was taken.                                        (9c)
  void learn(const SlantEquations& seen, float f, const SlantOptions& options) {
    if (!seen.valid || !(seen.rms < options.max_rms)) return;
    const float weight = 1 / (options.sigma_intensity * options.sigma_intensity), prior = f / options.sigma_tangent;
    information_ += weight * seen.H;
    Mat<float, 2, 2> inverse;
    if (!invert(Mat<float, 2, 2>(information_ + prior * prior * identity<float, 2>()), inverse)) return;
    const Vec<float, 2> a = a_ + weight * (inverse * seen.h);
    const float tangent = f * norm(a);
    a_ = tangent > options.max_tangent ? Vec<float, 2>(a * (options.max_tangent / tangent)) : a;
  }

 private:
  Vec<float, 2> a_ = zeros<float, 2>();
  Mat<float, 2, 2> information_ = zeros<float, 2, 2>();  ///< Lambda
};

/// A point by its pixels, and the surface that they are of.
struct PointAppearance {
  ReferencePatch patch;
  SurfaceSlant slant;
};

}  // namespace plumbline
