#pragma once
/// Rotation between two images from their coarsest pixels alone, without features.          docs/math/tracking.md
///
///   r_i(R)  = I_cur(pi(R b_i + q)) - I_prev(u_i) - mean    b_i bearing of pixel u_i of the previous image    (12)
///   dr_i/dphi = -g_i J_pi(b_i) [b_i]x                       inverse compositional: g_i gradient of I_prev     (13)
///   R <- R Exp(dphi)
/// On an image of about 40 x 30 pixels a motion of 40 px is one of 2.5 px: it gives optical flow a start where neither
/// gyroscope nor constant velocity can (the first frames, hands that shake). Of translation a guess is taken, q, as if
/// all were equally far; near things are rejected_by_consensus by a robust weight.

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/matrix.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/lie/so3.hpp"
#include "plumbline/solver/gauss_newton.hpp"

namespace plumbline {

struct RotationAlignmentOptions {
  int max_iterations = 12;
  float step_tolerance_rad = 1e-3f;
  float huber_intensity = 10;  ///< residuals beyond it count less
  float min_overlap = 0.4f;    ///< of the previous image's pixels seen by the current one
};

/// The 2x2 means of a pyramid's top level: level Pyr::levels, as float; NaN where its mask excludes the middle.
template <std::size_t MaxPixels>
class Thumbnail {
 public:
  template <class Pyr>
  void build(const Pyr& pyramid) {
    const ImageView<const std::uint8_t> top = pyramid.level(Pyr::levels - 1);
    width_ = top.width / 2;
    height_ = top.height / 2;
    scale_ = static_cast<float>(1 << Pyr::levels);
    for (int y = 0; y < height_; ++y) {
      const std::uint8_t* upper = top.row(2 * y);
      const std::uint8_t* lower = top.row(2 * y + 1);
      for (int x = 0; x < width_; ++x) {
        pixels_[static_cast<std::size_t>(y * width_ + x)] =
            pyramid.mask().excludes(to_full(Vec<float, 2>(float(x), float(y))))
                ? std::numeric_limits<float>::quiet_NaN()
                : 0.25f * static_cast<float>(upper[2 * x] + upper[2 * x + 1] + lower[2 * x] + lower[2 * x + 1]);
      }
    }
  }

  ImageView<const float> view() const { return {pixels_.data(), width_, height_, width_}; }
  /// Pixel of the full image seen in the thumbnail, and back.
  Vec<float, 2> from_full(const Vec<float, 2>& uv) const {
    return {(uv.x() + 0.5f) / scale_ - 0.5f, (uv.y() + 0.5f) / scale_ - 0.5f};
  }
  Vec<float, 2> to_full(const Vec<float, 2>& uv) const {
    return {(uv.x() + 0.5f) * scale_ - 0.5f, (uv.y() + 0.5f) * scale_ - 0.5f};
  }
  float scale() const { return scale_; }

 private:
  std::array<float, MaxPixels> pixels_{};
  int width_ = 0, height_ = 0;
  float scale_ = 1;
};

template <std::floating_point S>
struct RotationAlignment {
  bool valid = false;
  SO3<S> R_cur_prev;
  float cost = 0;      ///< mean robust squared residual [intensity^2]
  bool moved = false;  ///< holds beside the translation that was guessed, not instead of it
};

template <CameraModel Camera, std::size_t MaxPixels>
class RotationAligner {
 public:
  using S = typename Camera::Scalar;
  static constexpr int grid_limit = 4096;  ///< pixels that take part at most

  /// Linearizes the previous image.
  void set_previous(const Camera& camera, const Thumbnail<MaxPixels>& previous) {
    const ImageView<const float> image = previous.view();
    const int step = image.width * image.height > grid_limit ? 2 : 1;
    count_ = 0;
    for (int y = 1; y + 1 < image.height; y += step) {
      for (int x = 1; x + 1 < image.width && count_ < grid_limit; x += step) {
        const Vec<float, 2> uv = previous.to_full(Vec<float, 2>(float(x), float(y)));
        const Unprojection<S> ray = camera.unproject(cast_to<S>(uv));
        if (!ray.valid) continue;
        const Vec<S, 3>& b = ray.bearing;
        const Projection<S> projection = camera.project(b);
        if (!projection.valid) continue;
        // Gradient per full pixel: the thumbnail's pixel is `scale` of them wide.
        const Vec<float, 2> g = Vec<float, 2>(image(x + 1, y) - image(x - 1, y), image(x, y + 1) - image(x, y - 1)) /
                                (2 * previous.scale());
        if (!(std::abs(image(x, y)) + squared_norm(g) < largest)) continue;  // excluded, or beside what is
        Sample& sample = samples_[static_cast<std::size_t>(count_++)];
        sample.bearing = b;
        sample.intensity = image(x, y);
        const Mat<S, 1, 2> minus_g(S(-g.x()), S(-g.y()));
        sample.J = cast_to<float>(product(product(minus_g, projection.J_uv_p), hat(b)));  // (13)
      }
    }
  }

  /// `parallax` is q, the origin of the previous camera in the current one over the range of what is seen.
  RotationAlignment<S> align(const Camera& camera, const Thumbnail<MaxPixels>& current, SO3<S> R_cur_prev,
                             const Vec<S, 3>& parallax, const RotationAlignmentOptions& options) const {
    RotationAlignment<S> best;
    for (int iteration = 0; iteration < options.max_iterations; ++iteration) {
      DenseNormalEquations<float, 4> system;  // rotation and mean brightness
      int seen = 0;
      for (int i = 0; i < count_; ++i) {
        const Sample& sample = samples_[static_cast<std::size_t>(i)];
        const Projection<S> projection = camera.project(R_cur_prev * sample.bearing + parallax);
        if (!projection.valid) continue;
        const Vec<float, 2> uv = current.from_full(cast_to<float>(projection.uv));
        if (!current.view().contains(uv.x(), uv.y(), 0.5f)) continue;
        const float r = interpolate_inside(current.view(), uv) - sample.intensity;
        if (!(std::abs(r) < largest)) continue;
        const float size = std::abs(r), k = options.huber_intensity;
        const float weight = size > k ? k / size : 1.0f;
        Mat<float, 1, 4> J;
        set_block(J, 0, 0, sample.J);
        J[3] = -1.0f;
        system.add(J, Vec<float, 1>(r), weight);
        system.add_cost(weight * r * r);
        ++seen;
      }
      if (!(float(seen) >= options.min_overlap * float(count_)) || seen < 16) break;
      const float cost = 2 * system.cost() / float(seen);
      if (!best.valid || cost < best.cost) best = {true, R_cur_prev, cost};
      Vec<float, 4> d;
      if (!system.solve(d)) break;
      const Vec<float, 3> dphi = segment<3>(d, 0);
      R_cur_prev = R_cur_prev * SO3<S>::exp(cast_to<S>(dphi));
      if (norm(dphi) < options.step_tolerance_rad) break;
    }
    return best;
  }

 private:
  static constexpr float largest = std::numeric_limits<float>::max();  ///< NaN is not below it

  struct Sample {
    Vec<S, 3> bearing;
    Mat<float, 1, 3> J;
    float intensity;
  };

  static float interpolate_inside(const ImageView<const float>& image, const Vec<float, 2>& uv) {
    return interpolate(image, std::min(uv.x(), float(image.width) - 1.001f),
                       std::min(uv.y(), float(image.height) - 1.001f));
  }

  std::array<Sample, grid_limit> samples_;
  int count_ = 0;
};

}  // namespace plumbline
