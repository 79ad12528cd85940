// Any sequence of calls of an estimator with an IMU and a camera, or a camera with depth: late, early and repeated
// times, NaN, infinite and huge samples, wrong sizes, images that jump, resets. Every estimate is finite and has the
// frame's time; an error changes nothing.
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>

#include <fuzzer/FuzzedDataProvider.h>

#include "fuzz_folder.hpp"
#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/backend/sliding_window.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"
#include "plumbline/sensor/rig.hpp"

namespace pl = plumbline;

namespace {

constexpr int width = 96, height = 72, margin = 24;
template <template <class, std::size_t, class> class Vision>
using Sensors = pl::Rig<Vision<pl::Pinhole<float>, width * height, pl::Global>, pl::Imu>;
using MonoVio = pl::Estimator<Sensors<pl::Mono>, pl::Features<pl::Points<24>>, pl::SlidingWindow<4>>;
using RgbdVio = pl::Estimator<Sensors<pl::Rgbd>, pl::Features<pl::Points<24>>, pl::DirectGaussNewton<4>>;

/// Random squares, larger than an image.
struct Texture {
  static constexpr int w = width + 2 * margin, h = height + 2 * margin;
  std::array<std::uint8_t, w * h> pixels{};

  Texture() {
    pl::Random random(1);
    std::array<std::uint8_t, 32 * 32> squares{};
    for (std::uint8_t& level : squares) level = std::uint8_t(random.next() >> 24);
    for (int y = 0; y < h; ++y)
      for (int x = 0; x < w; ++x) pixels[std::size_t(y * w + x)] = squares[std::size_t(y / 6 * 32 + x / 6)];
  }
};

template <class Sensors>
Sensors sensors() {
  Sensors out{};
  out.vision.camera = {.fx = 80, .fy = 80, .cx = 47.5f, .cy = 35.5f};
  out.vision.width = width;
  out.vision.height = height;
  if constexpr (Sensors::has_depth) out.vision.depth.units_per_meter = 1000;
  return out;
}

pl::TimeNs next_time(FuzzedDataProvider& data, pl::TimeNs last, pl::TimeNs step) {
  constexpr pl::TimeNs s = 1'000'000'000;
  constexpr pl::TimeNs far = pl::TimeNs(1) << 61;  // 73 years: differences of two times do not overflow
  switch (data.ConsumeIntegralInRange(0, 15)) {
    case 0: return last;
    case 1: return last - step;
    case 2: return last + s;
    case 3: return std::min(last, far - 3600 * s) + 3600 * s;
    case 4: return data.ConsumeIntegralInRange<pl::TimeNs>(-far, far);
    default: return std::min(last, far - step) + step;
  }
}

double value(FuzzedDataProvider& data, double usual) {
  switch (data.ConsumeIntegralInRange(0, 31)) {
    case 0: return std::numeric_limits<double>::quiet_NaN();
    case 1: return std::numeric_limits<double>::infinity();
    case 2: return 1e300;
    case 3: return -1e30;
    case 4: return 1e-310;
    case 5: return data.ConsumeFloatingPointInRange<double>(-2000, 2000);
    default: return usual + data.ConsumeIntegralInRange(-50, 50) * 0.01;
  }
}

template <class Derived>
bool is_finite(const Eigen::MatrixBase<Derived>& m) {
  return m.allFinite();
}

template <class Vio, class Sensors>
void run(FuzzedDataProvider& data) {
  static const Texture texture;
  static std::array<std::uint16_t, width * height> depth;
  depth.fill(2000);
  const auto vio = std::make_unique<Vio>(sensors<Sensors>());
  pl::TimeNs imu_ns = 0, frame_ns = 0;
  int x = 0, y = 0;
  for (int calls = 0; calls < 200 && data.remaining_bytes() > 0; ++calls) {
    const int what = data.ConsumeIntegralInRange(0, 15);
    if (what < 10) {  // a handful of samples
      for (int i = 0; i < 5; ++i) {
        const pl::TimeNs t = next_time(data, imu_ns, 10'000'000);
        const pl::ImuSample sample{
            t, {value(data, 0), value(data, 0), value(data, 0)}, {value(data, 0), value(data, -9.81), value(data, 0)}};
        if (vio->add_imu(sample)) imu_ns = t;
      }
    } else if (what < 15) {
      const pl::TimeNs t = next_time(data, frame_ns, 50'000'000);
      x = std::clamp(x + data.ConsumeIntegralInRange(-3, 3), 0, 2 * margin);
      y = std::clamp(y + data.ConsumeIntegralInRange(-3, 3), 0, 2 * margin);
      const int odd = data.ConsumeIntegralInRange(0, 31);
      const int w = odd == 0 ? width - 1 : odd == 1 ? 0 : width, h = odd == 2 ? -height : height;
      const std::uint8_t* pixels = odd == 3 ? nullptr : &texture.pixels[std::size_t(y * Texture::w + x)];
      const pl::TimeNs before_ns = vio->latest().t_ns;
      typename Sensors::Frame frame{.t_ns = t, .gray = {pixels, w, h, Texture::w}};
      if constexpr (Sensors::has_depth) {
        if (odd != 4) frame.depth = {depth.data(), odd == 5 ? w - 1 : w, h, width};
        if (odd == 6) depth.fill(data.ConsumeIntegral<std::uint16_t>());
      }
      const auto estimate = vio->add_frame(frame);
      if (!estimate) {
        require(vio->latest().t_ns == before_ns, "an error changes nothing");
        continue;
      }
      frame_ns = t;
      require(estimate->t_ns == t, "an estimate has the frame's time");
      require(is_finite(estimate->T_world_body.R()) && is_finite(estimate->T_world_body.p()), "a pose is finite");
      require(is_finite(estimate->covariance), "a covariance is finite");
      require(is_finite(estimate->v_world_body) && is_finite(estimate->bias_gyro) && is_finite(estimate->bias_accel),
              "velocity and biases are finite");
      require(std::isfinite(estimate->time_offset_s), "a time offset is finite");
    } else {
      vio->request_reset();
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  FuzzedDataProvider data(bytes, size);
  if (data.ConsumeBool()) {
    run<RgbdVio, Sensors<pl::Rgbd>>(data);
  } else {
    run<MonoVio, Sensors<pl::Mono>>(data);
  }
  return 0;
}
