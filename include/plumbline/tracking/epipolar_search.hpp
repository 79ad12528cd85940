#pragma once
/// Search for a point whose range is known roughly along the curve that its ray draws in the current image.
///                                                                                          docs/math/direct.md
///   P(lambda) = R b + lambda t,   u(lambda) = pi(P),   du/dlambda = J_pi(P) t,   lambda = 1/range             (15)
///   D(u) = 1/n sum_j (I(u + D_j) - mean I - T_j + mean T)^2,   T the warped reference                         (16)
/// The curve is walked from the expected lambda toward both ends in even steps of the image, with the camera's own
/// projection: no camera has to draw it straight. The place with the least D is aligned, where it is clearly like the
/// reference and no place away from it is nearly as good.

#include <algorithm>
#include <cstdint>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/patch.hpp"
#include "plumbline/image/patch_sums.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/reference_patch.hpp"

namespace plumbline {

struct EpipolarSearchOptions {
  float step_px = 0.8f;                 ///< along the curve [px of the search level]
  float max_difference = 0.4f;          ///< D of the best place, in variances of the reference patch
  float min_difference = 0.1f;          ///< the same of places that are all alike: noise and warp explain as much
  float uniqueness = 1.5f;              ///< D of every place away from the best one is larger by this factor
  float away_px = 3;                    ///< [px of the search level]
  static constexpr int max_steps = 64;  ///< both ways together; a longer curve is searched on a coarser level
};

/// lambda of (15) [1/m].
template <class S>
struct InverseRangeInterval {
  S expected, low, high;
};

template <class S>
struct EpipolarMatch {
  Alignment aligned;  ///< not valid: nothing found, or more than one place
  S inverse_range;    ///< of the place on the curve that was aligned [1/m]
};

/// A reference patch without its mean, against places of an image.                                              (16)
template <int Size = 8>
class PatchDifference {
 public:
  /// False where the reference does not cover the warp.
  bool set(const ReferencePatch& reference, const Mat<float, 2, 2>& A_cur_ref, int level) {
    if (!warp_template<Size>(reference, A_cur_ref, level, T_)) return false;
    const float mean = mean_of(T_);
    for (int k = 0; k < Size * Size; ++k) T_[k] -= mean;
    return true;
  }
  float variance() const { return sum_of_squares(T_) / samples; }
  /// `uv` [px of the level], with the whole patch inside.
  float at(const ImageView<const std::uint8_t>& image, const Vec<float, 2>& uv) const {
    Patch<Size> I;
    interpolate_patch<Size>(image, uv, I);
    for (int k = 0; k < Size * Size; ++k) I[k] -= T_[k];
    return squared_norm_about(I, mean_of(I)) / samples;  // T has no mean
  }

 private:
  static constexpr float samples = Size * Size;
  Patch<Size> T_;
};

/// A place of the curve.
template <class S>
struct EpipolarPlace {
  S lambda;          ///< [1/m]
  Vec<float, 2> uv;  ///< [px of the search level]
  float difference;  ///< D of (16)
};

/// The place with the least difference; null where it is not like the reference, or where another one is, too.
template <class Places>
const typename Places::value_type* clearly_best(const Places& places, float variance,
                                                const EpipolarSearchOptions& options) {
  const auto best = std::min_element(places.begin(), places.end(),
                                     [](const auto& a, const auto& b) { return a.difference < b.difference; });
  if (best == places.end() || !(best->difference < options.max_difference * variance)) return nullptr;
  const float rival = options.uniqueness * std::max(best->difference, options.min_difference * variance);
  for (const auto& place : places) {
    const bool away = squared_norm(place.uv - best->uv) > options.away_px * options.away_px;
    if (away && !(place.difference > rival)) return nullptr;
  }
  return best;
}

/// `reference` was taken where `camera` sees `bearing_ref`; T_cur_ref maps coordinates of that camera into the current
/// one. `seen(uv, lambda)` maps a pixel of the middle of the current frame, in that inverse range, to where the image
/// shows it: the identity but for rolling shutters.
template <CameraModel Camera, class Pyr, class S = typename Camera::Scalar>
EpipolarMatch<S> search_epipolar_curve(const Camera& camera, const ReferencePatch& reference,
                                       const Vec<typename Camera::Scalar, 3>& bearing_ref,
                                       const InverseRangeInterval<typename Camera::Scalar>& lambda,
                                       const SE3<typename Camera::Scalar>& T_cur_ref, const Pyr& current, auto&& seen,
                                       const EpipolarSearchOptions& options, AlignmentOptions alignment) {
  constexpr int patch_size = 8, max_steps = EpipolarSearchOptions::max_steps;
  EpipolarMatch<S> out{{false, zeros<float, 2>(), 0, 0.0f, zeros<float, 2, 2>()}, lambda.expected};
  const Vec<S, 3> Rb = T_cur_ref.rotation() * bearing_ref;
  const auto project = [&](S at) { return camera.project(Vec<S, 3>(Rb + at * T_cur_ref.p())); };
  const auto px_per_lambda = [&](const Projection<S>& at) { return norm(product(at.J_uv_p, T_cur_ref.p())); };  // (15)
  const auto warp = [&](S at) { return affine_warp(camera, camera, bearing_ref, S(1) / at, T_cur_ref).A_cur_ref; };

  const Projection<S> middle = project(lambda.expected);
  if (!(lambda.expected > S(0)) || !middle.valid) return out;
  const Mat<float, 2, 2> A = warp(lambda.expected);
  const int finest = search_level(A, Pyr::levels - 1);
  if (finest < 0 || reference.levels() == 0) return out;
  // The level on which the curve is short enough; NaN leaves the finest.
  const float length_px = float(px_per_lambda(middle) * (lambda.high - lambda.low));
  int level = finest;
  while (level + 1 < Pyr::levels && length_px > options.step_px * float(max_steps << level)) ++level;
  PatchDifference<patch_size> difference;
  if (!difference.set(reference, A, level)) return out;

  FixedVector<EpipolarPlace<S>, max_steps + 1> places;
  const ImageView<const std::uint8_t>& image = current.level(level);
  const auto look = [&](S at, const Projection<S>& projection) {
    const S inverse_range = at / norm(Vec<S, 3>(Rb + at * T_cur_ref.p()));
    const Vec<float, 2> uv = to_level(cast_to<float>(seen(projection.uv, inverse_range)), level);
    if (patch_inside(image, uv, patch_size)) places.push_back({at, uv, difference.at(image, uv)});
  };
  look(lambda.expected, middle);
  const S step_px = S(options.step_px) * S(1 << level);
  for (const S way : {S(1), S(-1)}) {
    S at = lambda.expected;
    Projection<S> here = middle;
    for (int k = 0; k < max_steps / 2; ++k) {
      at += way * step_px / px_per_lambda(here);
      if (!(at > lambda.low && at < lambda.high)) break;  // NaN too
      here = project(at);
      if (!here.valid) break;
      look(at, here);
    }
  }

  const EpipolarPlace<S>* best = clearly_best(places, difference.variance(), options);
  if (!best) return out;
  out.inverse_range = best->lambda;
  alignment.coarse_start = level > finest;
  out.aligned = align_patch(reference, warp(best->lambda), current, from_level(best->uv, level), alignment);
  return out;
}

}  // namespace plumbline
