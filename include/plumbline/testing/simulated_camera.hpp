#pragma once
/// The camera of a simulated recording: rendered frames with the optics and noise of a sensor, and its depth image.
///
///   gray  = clamp(round(e(t) PSF * L + n)),        n ~ N(0, noise_sigma^2) for each pixel                      (1)
///   depth = round(1000 (z + m)) mm,                m ~ N(0, (depth_sigma z^2)^2), as structured light          (2)
/// Depth has holes off the range and at the edges of surfaces. Frame `i` depends on the seed and i alone.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "plumbline/image/image_view.hpp"
#include "plumbline/lie/se3.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/renderer.hpp"

namespace plumbline::testing {

/// An image that owns its pixels.
template <class Pixel>
class Image {
 public:
  Image(int width, int height) : width_(width), height_(height), pixels_(static_cast<std::size_t>(width * height)) {}
  ImageView<Pixel> view() { return {pixels_.data(), width_, height_, width_}; }
  ImageView<const Pixel> view() const { return {pixels_.data(), width_, height_, width_}; }
  const std::vector<Pixel>& pixels() const { return pixels_; }

 private:
  int width_, height_;
  std::vector<Pixel> pixels_;
};

struct CameraEffects {
  double noise_sigma = 1.2;                 ///< [gray levels]
  double blur_px = 0.45;                    ///< sigma of the point spread function, at most 0.7
  double exposure_amplitude = 0;            ///< e(t) = 1 + amplitude sin(2 pi t / period)
  double exposure_period_s = 6;             ///< [s]
  double exposure_time_s = 0;               ///< > 0: motion blur, centered on the time stamp
  int exposure_steps = 7;                   ///< rendered images averaged over the exposure
  double readout_s = 0;                     ///< > 0: rows are exposed one after the other, the middle one at the stamp
  double depth_sigma = 1.5e-3;              ///< [1/m]; 1.4 cm at 3 m
  double depth_min = 0.4, depth_max = 6.0;  ///< [m]
  double edge_ratio = 0.04;                 ///< depth step over depth from which a pixel counts as an edge
  double edge_dropout = 0.6;                ///< probability of a hole there
};

class SimulatedCamera {
 public:
  struct Frame {
    Image<std::uint8_t> gray;
    Image<std::uint16_t> depth;  ///< [mm], 0: no measurement
  };

  SimulatedCamera(Renderer renderer, const SE3<double>& T_body_camera, const CameraEffects& effects, std::uint64_t seed)
      : renderer_(std::move(renderer)), T_body_camera_(T_body_camera), effects_(effects), seed_(seed) {}

  /// Frame number `i` at time t [s] of a path (Trajectory, RecordedPath).
  template <class Path>
  Frame frame(const Path& trajectory, double t, std::uint64_t i) {
    const int width = renderer_.width(), height = renderer_.height();
    Image<float> light(width, height), z(width, height);
    if (effects_.exposure_time_s > 0) {
      Image<float> step(width, height);
      for (int k = 0; k < effects_.exposure_steps; ++k) {
        const double offset = ((k + 0.5) / effects_.exposure_steps - 0.5) * effects_.exposure_time_s;
        expose(trajectory, t + offset, step, z);
        for (int y = 0; y < height; ++y) {
          for (int x = 0; x < width; ++x) {
            light.view()(x, y) += step.view()(x, y) / static_cast<float>(effects_.exposure_steps);
          }
        }
      }
      expose(trajectory, t, step, z);
    } else {
      expose(trajectory, t, light, z);
    }
    const double wave = std::sin(2 * std::numbers::pi * t / effects_.exposure_period_s);
    Frame out{Image<std::uint8_t>(width, height), Image<std::uint16_t>(width, height)};
    develop(light, 1 + effects_.exposure_amplitude * wave, stream_seed(seed_, 2, i), out.gray);
    measure_depth(z, stream_seed(seed_, 3, i), out.depth);
    return out;
  }

  Renderer& renderer() { return renderer_; }

 private:
  template <class Path>
  void expose(const Path& trajectory, double t, Image<float>& light, Image<float>& z) {
    const auto T_world_cam = [&](double at) { return trajectory.at(at).T_world_body * T_body_camera_; };
    if (!(effects_.readout_s > 0)) return renderer_.render(T_world_cam(t), light.view(), z.view());
    const double row_s = effects_.readout_s / renderer_.height(), top = t + 0.5 * (row_s - effects_.readout_s);
    renderer_.render_rolling([&](double row) { return T_world_cam(top + row * row_s); }, light.view(), z.view());
  }

  /// (1): separable three-tap blur of the same variance as the point spread function, gain, noise, rounding.
  void develop(Image<float>& light, double gain, std::uint64_t seed, Image<std::uint8_t>& out) const {
    const float side = static_cast<float>(effects_.blur_px * effects_.blur_px / 2), middle = 1 - 2 * side;
    const ImageView<float> in = light.view();
    const int width = in.width, height = in.height;
    std::vector<float> rows(static_cast<std::size_t>(3 * width));  // the last three rows, blurred along x
    const auto blurred = [&](int y) { return rows.data() + (y % 3) * width; };
    const auto blur_row = [&](int y) {
      const float* row = in.row(y);
      for (int x = 0; x < width; ++x) {
        blurred(y)[x] = middle * row[x] + side * (row[std::max(x - 1, 0)] + row[std::min(x + 1, width - 1)]);
      }
    };
    Gaussian noise(seed);
    blur_row(0);
    for (int y = 0; y < height; ++y) {
      if (y + 1 < height) blur_row(y + 1);
      const float *up = blurred(std::max(y - 1, 0)), *mid = blurred(y), *down = blurred(std::min(y + 1, height - 1));
      for (int x = 0; x < width; ++x) {
        const double value = gain * static_cast<double>(middle * mid[x] + side * (up[x] + down[x]));
        out.view()(x, y) =
            static_cast<std::uint8_t>(std::clamp(value + effects_.noise_sigma * noise(), 0.0, 255.0) + 0.5);
      }
    }
  }

  /// (2)
  void measure_depth(const Image<float>& exact, std::uint64_t seed, Image<std::uint16_t>& out) const {
    const ImageView<const float> in = exact.view();
    Gaussian noise(seed);
    for (int y = 0; y < in.height; ++y) {
      const float *mid = in.row(y), *up = in.row(std::max(y - 1, 0)), *down = in.row(std::min(y + 1, in.height - 1));
      for (int x = 0; x < in.width; ++x) {
        const double z = static_cast<double>(mid[x]), measured = z + effects_.depth_sigma * z * z * noise();
        const auto [lowest, highest] =
            std::minmax({mid[x], mid[std::max(x - 1, 0)], mid[std::min(x + 1, in.width - 1)], up[x], down[x]});
        const double step = static_cast<double>(highest - lowest);
        const bool hole = step > effects_.edge_ratio * z && noise.random().uniform() < effects_.edge_dropout;
        const bool in_range = z >= effects_.depth_min && z <= effects_.depth_max;
        out.view()(x, y) =
            in_range && !hole ? static_cast<std::uint16_t>(std::lround(1000 * measured)) : std::uint16_t(0);
      }
    }
  }

  Renderer renderer_;
  SE3<double> T_body_camera_;
  CameraEffects effects_;
  std::uint64_t seed_;
};

}  // namespace plumbline::testing
