#pragma once
/// A camera with depth images registered to its gray images pixel by pixel.

#include <cstddef>
#include <cstdint>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/sensor/depth_sensor.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

/// The default is a rolling shutter with unknown readout time, because most depth cameras have one.
template <CameraModel CameraT, std::size_t MaxPixels = 752 * 480, class ShutterT = Rolling>
struct Rgbd {
  using Camera = CameraT;
  using Shutter = ShutterT;
  using Scalar = typename Camera::Scalar;
  static constexpr std::size_t max_pixels = MaxPixels;
  static constexpr bool has_depth = true;

  /// Data of one frame. A frame with an empty depth view is used like one of a gray camera.
  struct Frame {
    TimeNs t_ns = 0;
    ImageView<const std::uint8_t> gray;
    ImageView<const std::uint16_t> depth;
  };

  Camera camera;
  int width = 0;   ///< [px] of every image
  int height = 0;  ///< [px]
  DepthSensor<Scalar> depth;
  [[no_unique_address]] Present<Readout<Scalar>, Shutter::rolls> readout{{Scalar(0), Scalar(0.02)}};
};

}  // namespace plumbline
