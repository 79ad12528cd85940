#pragma once
/// A single gray camera. The largest image size is part of the type, because it sizes every image buffer.

#include <cstddef>
#include <cstdint>

#include "plumbline/camera/camera_model.hpp"
#include "plumbline/core/present.hpp"
#include "plumbline/core/time.hpp"
#include "plumbline/image/image_view.hpp"
#include "plumbline/sensor/rolling_shutter.hpp"

namespace plumbline {

template <CameraModel CameraT, std::size_t MaxPixels = 752 * 480, class ShutterT = Global>
struct Mono {
  using Camera = CameraT;
  using Shutter = ShutterT;
  using Scalar = typename Camera::Scalar;
  static constexpr std::size_t max_pixels = MaxPixels;
  static constexpr bool has_depth = false;

  /// Data of one frame; the pixels must stay valid during the call that receives it.
  struct Frame {
    TimeNs t_ns = 0;
    ImageView<const std::uint8_t> gray;
  };

  Camera camera;
  int width = 0;   ///< [px] of every image
  int height = 0;  ///< [px]
  [[no_unique_address]] Present<Readout<Scalar>, Shutter::rolls> readout{};
};

}  // namespace plumbline
