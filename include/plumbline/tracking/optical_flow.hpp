#pragma once
/// Pyramidal Lucas-Kanade flow of single points, inverse compositional, with gain and bias per patch.
///                                                                                         docs/math/tracking.md
/// From the top level down, each level refines the position found above with PatchTemplate. A level whose patch does
/// not fit, has no texture or does not converge leaves the position as it is; level 0 must succeed.

#include <cstdint>

#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/image/patch.hpp"
#include "plumbline/image/pyramid.hpp"
#include "plumbline/tracking/patch_template.hpp"

namespace plumbline {

struct OpticalFlowOptions {
  int max_iterations = 15;         ///< a level
  float epsilon_px = 0.02f;        ///< converged on level 0; coarse_epsilon_px above
  float coarse_epsilon_px = 0.1f;  ///< [px of the level]
  float max_rms = 20.0f;           ///< intensity residual after gain and bias
  float min_gain = 0.5f, max_gain = 2.0f;
  float min_eigenvalue = 0.5f;       ///< texture per pixel [intensity^2/px^2]
  float forward_backward_px = 0.5f;  ///< largest disagreement of the way back
  int backward_levels = 2;           ///< the way back starts near: fine levels suffice
};

struct FlowResult {
  bool valid;
  Vec<float, 2> uv;  ///< [px] of level 0
  float rms;         ///< intensity residual
};

/// The flow of one point through `levels` levels. The patch has PatchSize x PatchSize samples on each.
template <int PatchSize = 12, class Pyr>
FlowResult track_point_levels(const Pyr& previous, const Pyr& current, const Vec<float, 2>& uv_previous,
                              const Vec<float, 2>& uv_guess, const OpticalFlowOptions& options, int levels) {
  using Template = PatchTemplate<PatchSize>;
  FlowResult out{false, uv_guess, 0.0f};
  Template patch;
  typename Template::Bordered bordered;
  if (!patch_inside(previous.level(0), uv_previous, Template::bordered_size)) return out;
  for (int l = levels - 1; l >= 0; --l) {
    const ImageView<const std::uint8_t> reference = previous.level(l), image = current.level(l);
    const Vec<float, 2> center = to_level(uv_previous, l);
    interpolate_patch<Template::bordered_size>(reference, center, bordered);
    patch.set(bordered);
    if (!(patch.min_eigenvalue() > options.min_eigenvalue)) continue;
    const PatchSearch bounds{options.max_iterations, l == 0 ? options.epsilon_px : options.coarse_epsilon_px,
                             static_cast<float>(PatchSize)};
    const PatchMatch match = patch.search(image, to_level(out.uv, l), bounds);
    if (!match.valid) continue;
    out.uv = from_level(match.uv, l);
    out.rms = match.rms;
    out.valid = l == 0 && match.rms < options.max_rms && match.gain > options.min_gain &&
                match.gain < options.max_gain && patch_inside(image, match.uv, PatchSize);
  }
  return out;
}

/// Flow of `uv_previous` [px] from the previous to the current image, searched from `uv_guess` [px].
template <int PatchSize = 12, class Pyr>
FlowResult track_point(const Pyr& previous, const Pyr& current, const Vec<float, 2>& uv_previous,
                       const Vec<float, 2>& uv_guess, const OpticalFlowOptions& options) {
  return track_point_levels<PatchSize>(previous, current, uv_previous, uv_guess, options, Pyr::levels);
}

/// The same, then back again: valid only when the way back ends within `forward_backward_px` of its origin.
template <int PatchSize = 12, class Pyr>
FlowResult track_point_checked(const Pyr& previous, const Pyr& current, const Vec<float, 2>& uv_previous,
                               const Vec<float, 2>& uv_guess, const OpticalFlowOptions& options) {
  FlowResult forward = track_point<PatchSize>(previous, current, uv_previous, uv_guess, options);
  if (!forward.valid) return forward;
  const int levels = options.backward_levels < Pyr::levels ? options.backward_levels : Pyr::levels;
  const FlowResult backward =
      track_point_levels<PatchSize>(current, previous, forward.uv, uv_previous, options, levels);
  forward.valid = backward.valid && norm(backward.uv - uv_previous) <= options.forward_backward_px;
  return forward;
}

}  // namespace plumbline
