#pragma once
/// The pyramids of the current image and of the one that it is compared with.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include "plumbline/core/matrix.hpp"
#include "plumbline/feature/view.hpp"
#include "plumbline/image/image_mask.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/sensor/rig.hpp"
#include "plumbline/tracking/rotation_alignment.hpp"

namespace plumbline {

template <SensorRig Sensors>
class ImagePair {
 public:
  using S = typename Sensors::Scalar;
  using Frame = typename Sensors::Frame;

  explicit ImagePair(const RotationAlignmentOptions& options) : options_(options) {}

  /// Whether gray and depth image have the size of the rig.
  static bool has_right_size(const Sensors& rig, const Frame& frame) {
    if (frame.gray.width != rig.vision.width || frame.gray.height != rig.vision.height) return false;
    if constexpr (Sensors::has_depth) {
      const auto& depth = frame.depth;
      return depth.empty() || (depth.width == frame.gray.width && depth.height == frame.gray.height);
    }
    return true;
  }

  /// Builds the pyramid of a new image. False when it is too small or too large.
  bool take_in(const Frame& frame) {
    for (auto& pyramid : pyramids_) pyramid.set_mask(mask_.view());
    return pyramids_[1 - kept_].build(frame.gray);
  }

  /// Excludes the zero pixels of `mask` from the next image on; none if it is empty. False if it has not the size of
  /// the rig; the mask is then unchanged.
  bool set_mask(const Sensors& rig, const ImageView<const std::uint8_t>& mask) {
    const bool has_size = mask.width == rig.vision.width && mask.height == rig.vision.height;
    return (mask.empty() || has_size) && mask_.set(mask);
  }

  /// The new frame with the kept one as the previous image.
  View<Sensors> view(const Sensors& rig, const Frame& frame, const SE3<S>& T_body_cam, const Readout<S>& readout,
                     S dt) const {
    const auto depth = [&]() -> ImageView<const std::uint16_t> {
      if constexpr (Sensors::has_depth) return frame.depth;
      return {};
    };
    return {frame.t_ns,
            dt,
            rig,
            pyramids_[kept_],
            pyramids_[1 - kept_],
            depth(),
            T_world_kept_,
            T_body_cam,
            {rig.vision.camera, rig.vision.height, readout.value_s, readout.is_known()}};
  }

  /// Whether the new image equals the kept one in all pixels of the coarsest level: a camera driver that repeats
  /// images. Two exposures differ by noise.
  bool repeats() const {
    constexpr int coarsest = RigPyramid<Sensors>::levels - 1;
    const auto &a = pyramids_[0].level(coarsest), &b = pyramids_[1].level(coarsest);
    if (a.width != b.width || a.height != b.height) return false;
    for (int v = 0; v < a.height; ++v) {
      if (!std::equal(a.row(v), a.row(v) + a.width, b.row(v))) return false;
    }
    return true;
  }

  /// Whether the contrast of the new image is more than a quarter of that of the kept one; black images and blank walls
  /// have less.
  bool has_contrast() const { return contrast(1 - kept_) > least_contrast * contrast(kept_); }

  /// Keeps the new image, with its pose, for the comparison with the next one.
  void keep(const View<Sensors>& view, const SE3<S>& T_world_body) {
    kept_ = &view.current == &pyramids_[0] ? 0 : 1;
    T_world_kept_ = T_world_body;
  }

  /// Rotation of the camera from the previous to the current image by alignment of their thumbnails. Two hypotheses are
  /// compared and the one with the lower cost is returned: a camera with the predicted motion `T_cur_prev` at the
  /// distance `range` from the scene, and a stationary one. With `after_gap` a grid of rotations around the predicted
  /// one is searched first.
  RotationAlignment<S> align_motion(const View<Sensors>& view, const SE3<S>& T_cur_prev, S range, bool after_gap) {
    thumbnail_.build(view.previous);
    rotation_.set_previous(view.camera(), thumbnail_);
    thumbnail_.build(view.current);
    const auto align = [&](const SE3<S>& guess) {
      return rotation_.align(view.camera(), thumbnail_, guess.rotation(), Vec<S, 3>(guess.p() / range), options_);
    };
    RotationAlignment<S> moved = align(T_cur_prev);
    if (after_gap) moved = better(moved, align(SE3<S>(search(view.camera(), T_cur_prev, range), T_cur_prev.p())));
    moved.moved = true;
    return better(moved, align(SE3<S>()));
  }

 private:
  static constexpr float least_contrast = 0.25f;    ///< relative to the kept image; tuned: docs/decisions/135 (chosen)
  static constexpr int search_x = 5, search_y = 3;  ///< steps of the search to either side; tuned: docs/decisions/096
  static constexpr float search_step_px = 3;        ///< in pixels of the thumbnail; tuned: docs/decisions/135 (chosen)

  static RotationAlignment<S> better(const RotationAlignment<S>& a, const RotationAlignment<S>& b) {
    return b.valid && (!a.valid || b.cost < a.cost) ? b : a;
  }

  /// The rotation with the lowest cost on a grid around the predicted one.
  SO3<S> search(const typename Sensors::Camera& camera, const SE3<S>& T_cur_prev, S range) const {
    RotationAlignmentOptions one_iteration = options_;
    one_iteration.max_iterations = 1;
    const S step = S(search_step_px * thumbnail_.scale()) / S(effective_focal_length(camera));
    RotationAlignment<S> best;
    for (int y = -search_y; y <= search_y; ++y) {
      for (int x = -search_x; x <= search_x; ++x) {
        const SO3<S> R = SO3<S>::exp({S(y) * step, S(x) * step, S(0)}) * T_cur_prev.rotation();
        best = better(best, rotation_.align(camera, thumbnail_, R, Vec<S, 3>(T_cur_prev.p() / range), one_iteration));
      }
    }
    return best.R_cur_prev;
  }

  /// Mean absolute difference of horizontal neighbors in the coarsest level, without excluded pixels.
  float contrast(int k) const {
    constexpr int coarsest = RigPyramid<Sensors>::levels - 1;
    const auto& image = pyramids_[std::size_t(k)].level(coarsest);
    const MaskView mask = mask_.view();
    float sum = 0;
    for (int v = 0; v < image.height; ++v) {
      for (int u = 1; u < image.width; ++u) {
        if (mask.excludes(from_level(Vec<float, 2>(float(u) - 0.5f, float(v)), coarsest))) continue;
        sum += float(std::abs(image(u, v) - image(u - 1, v)));
      }
    }
    return image.width * image.height > 0 ? sum / float(image.width * image.height) : 0.0f;
  }

  static constexpr std::size_t thumbnail_pixels = decltype(Sensors::vision)::max_pixels >>
                                                  (2 * RigPyramid<Sensors>::levels);

  std::array<RigPyramid<Sensors>, 2> pyramids_;
  ImageMask<decltype(Sensors::vision)::max_pixels> mask_;
  SE3<S> T_world_kept_;
  int kept_ = 0;
  RotationAlignmentOptions options_;
  Thumbnail<thumbnail_pixels> thumbnail_;
  RotationAligner<typename Sensors::Camera, thumbnail_pixels> rotation_;
};

}  // namespace plumbline
