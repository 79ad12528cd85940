#pragma once
/// Patches of the older keyframe of a loop, aligned in the image of the current one.              docs/math/map.md 2
///
/// A corner is found again to about a pixel of its level, a patch to a fraction of one. Each keyframe keeps patches of
/// some of its features, tracked ones before corners. Where its pose is verified, each patch is aligned in the current
/// image under the warp between both views (feature_alignment.hpp), with
///   sigma^2 = sigma_px^2 4^l + rms^2 / lambda_min(H)      l the level, rms of the intensities, H (10a) of that (2b)

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/fixed_vector.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/map/place_keyframe.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/feature_alignment.hpp"
#include "plumbline/tracking/reference_patch.hpp"

namespace plumbline {

struct LoopAlignmentOptions {
  AlignmentOptions alignment;
  double sigma_px = 0.1;  ///< floor, on the level; geometry: interpolation, and surfaces that are not flat
  int border_px = 16;     ///< geometry: a patch on level 1
};

/// MaxPatches of each keyframe.
template <SensorRig Sensors, int MaxKeyframes, std::size_t MaxPatches>
class LoopAlignment {
 public:
  using S = typename Sensors::Scalar;
  using Image = RigPyramid<Sensors>;
  using Shutter = RigShutter<Sensors>;

  LoopAlignment(const Sensors& rig, const LoopAlignmentOptions& options)
      : rig_(rig), options_(options), focal_px_(effective_focal_length(rig.vision.camera)) {}

  /// Keeps patches of a new keyframe in that slot; `pixel(n)` is that of feature n in its image.
  template <class Keyframe, class PixelOf>
  void learn(int slot, const Keyframe& keyframe, const Image& image, PixelOf&& pixel) {
    Patches& patches = patches_[std::size_t(slot)];
    patches.id = keyframe.id;
    patches.kept.clear();
    for (int kind = 0; kind < kinds; ++kind) {
      for (std::size_t n = 0; n < keyframe.features.size() && !patches.kept.full(); ++n) {
        if (kind_of(keyframe.features[n]) != kind) continue;
        Patch patch{std::uint16_t(n), {}};
        if (patch.pixels.capture(image, pixel(n))) patches.kept.push_back(patch);
      }
    }
  }
  /// The image of the keyframe whose places are asked for.
  void set_image(const Image& image, const Shutter& shutter) {
    image_ = image;
    shutter_ = shutter;
  }
  /// visit(feature, bearing, sigma_rad): features of `old`, the keyframe in that slot, found in the image that was set,
  /// whose camera is at T_old_current; the unit is that of `old`.
  template <class Keyframe, class Visit>
  void align(int slot, const Keyframe& old, const SE3<S>& T_old_current, Visit&& visit) const {
    const Patches& patches = patches_[std::size_t(slot)];
    if (patches.id != old.id || !shutter_) return;
    const auto& camera = rig_.vision.camera;
    const SE3<S> T_current_old = T_old_current.inverse();
    for (const Patch& patch : patches.kept) {
      const PlaceFeature& feature = old.features[patch.feature];
      if (!feature.is_located()) continue;
      const Vec<S, 3> bearing = cast_to<S>(feature.bearing), p = T_current_old * Vec<S, 3>(S(feature.range) * bearing);
      const auto predicted = camera.project(p);
      if (!predicted.valid) continue;
      const S inverse_range = S(1) / norm(p);
      const Vec<float, 2> uv = cast_to<float>(shutter_->seen(predicted.uv, inverse_range));
      if (!is_inside(uv)) continue;
      const AffineWarp warp = affine_warp(camera, camera, bearing, S(feature.range), T_current_old);
      const Alignment aligned = align_patch<8>(patch.pixels, warp.A_cur_ref, image_, uv, options_.alignment);
      if (!aligned.valid || image_.mask().excludes(aligned.uv)) continue;
      const auto ray = camera.unproject(shutter_->still(cast_to<S>(aligned.uv), inverse_range).uv);
      const S sigma = sigma_rad(aligned);
      if (ray.valid && std::isfinite(sigma)) visit(feature, ray.bearing, sigma);
    }
  }

 private:
  struct Patch {
    std::uint16_t feature;
    PatchCopy<16, 1> pixels;
  };
  struct Patches {
    std::uint32_t id = 0;
    FixedVector<Patch, MaxPatches> kept;
  };
  static constexpr int kinds = 3;

  /// Those with the lowest number first: landmarks with a range, landmarks, corners with a range.
  static int kind_of(const PlaceFeature& feature) {
    if (feature.landmark != PlaceFeature::no_landmark) return feature.is_located() ? 0 : 1;
    return feature.is_located() ? 2 : kinds;
  }
  bool is_inside(const Vec<float, 2>& uv) const {
    const auto& level = image_.level(0);
    const float border = float(options_.border_px);
    return uv.x() >= border && uv.y() >= border && uv.x() <= float(level.width - 1) - border &&
           uv.y() <= float(level.height - 1) - border;
  }
  /// (2b)
  S sigma_rad(const Alignment& aligned) const {
    const Mat<float, 2, 2>& H = aligned.information_per_intensity;
    const float middle = (H(0, 0) + H(1, 1)) / 2, half_difference = (H(0, 0) - H(1, 1)) / 2;
    const float least = middle - std::sqrt(half_difference * half_difference + H(0, 1) * H(0, 1));
    const S floor = S(options_.sigma_px) * S(1 << aligned.level), rms = S(aligned.rms);
    return std::sqrt(floor * floor + rms * rms / S(least)) / focal_px_;
  }

  Sensors rig_;
  LoopAlignmentOptions options_;
  S focal_px_;
  Image image_;
  std::optional<Shutter> shutter_;  ///< of that image
  std::array<Patches, std::size_t(MaxKeyframes)> patches_;
};

/// Of maps without patches.
struct NoLoopAlignment {
  NoLoopAlignment(auto&&...) {}
  static void learn(auto&&...) {}
  static void set_image(auto&&...) {}
  static void align(auto&&...) {}
};

}  // namespace plumbline
