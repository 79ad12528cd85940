#pragma once
// The components of a small RGB-D estimator, and a textured wall before its camera.

#include <array>
#include <cstdint>
#include <memory>

#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/estimator/components.hpp"
#include "plumbline/estimator/composition.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/map/no_map.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

namespace plumbline::test {

struct SmallParts {
  static constexpr int width = 160, height = 128, slots = 4;
  using Sensors = Rig<Rgbd<Pinhole<double>, width * height>>;
  using Parts = Composition<Sensors, Features<Points<60>>, SlidingWindow<slots>>;
  using Options = EstimatorOptions<Parts>;
  using Window = KeyframeWindow<Parts, NoMap::Discard<double>>;
  using Tracker = Window::Tracker;
  using On = Components<Parts, NoMap::Discard<double>>;

  Options options;
  Sensors rig = [] {
    Sensors out{};
    out.vision.camera = {130, 130, 79.5, 63.5, {}};
    out.vision.width = width;
    out.vision.height = height;
    return out;
  }();
  RigState<Sensors> rig_state{rig, options.readout};
  std::unique_ptr<Tracker> tracker = std::make_unique<Tracker>(options);
  std::unique_ptr<Window> window = std::make_unique<Window>(rig, options, NoMap::Options{});
  Parts::Propagation propagation{rig, options.propagation};
  Window::Nav navigation{WorldFrameUncertainty<double>(0)};
  FrameReport report;
  TrackingStatus status;
  std::array<std::uint8_t, width * height> gray{};
  std::array<std::uint16_t, width * height> depth{};

  SmallParts() { depth.fill(2000); }

  On components() { return {*tracker, *window, propagation, rig_state, navigation, report, status}; }

  /// Squares of random brightness, moved by that many pixels to the left.
  void draw(int shift_px) {
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        const std::uint32_t square = std::uint32_t((x + shift_px) / 9) * 73856093u ^ std::uint32_t(y / 9) * 19349663u;
        gray[std::size_t(y * width + x)] = std::uint8_t(30 + (square * 2654435761u >> 24) * 3 / 4);
      }
    }
  }
  View<Sensors> view(TimeNs t_ns, double dt = 0.05) {
    const Sensors::Frame frame{t_ns, {gray.data(), width, height, width}, {depth.data(), width, height, width}};
    (void)tracker->images().take_in(frame);
    return tracker->images().view(rig, frame, rig_state.T_body_cam(), rig_state.readout(), dt);
  }
};

}  // namespace plumbline::test
