// A firmware that uses the library in float on a target without operating system. Nothing runs it: it is compiled,
// linked, and searched for symbols of a heap or of exceptions.
#include "all_firmware_headers.hpp"

namespace pl = plumbline;

// The board's own: where the C library ends up when all is lost, with nothing behind it.
extern "C" void abort() {
  while (true) asm volatile("");
}

namespace {

volatile float sensor_value = 0.5f;  // keeps the compiler from computing at compile time
volatile float actuator_value;

using Sensors = pl::Rig<pl::Rgbd<pl::Pinhole<float, pl::RadTan>, 160 * 128>>;
using Vo = pl::Estimator<Sensors, pl::Features<pl::Points<60>>, pl::SlidingWindow<5>>;

constexpr int width = 160, height = 128;
std::uint8_t gray[width * height];
std::uint16_t depth[width * height];

Sensors sensors() {
  Sensors out{};
  out.vision.camera = {.fx = 130, .fy = 130, .cx = 79.5f, .cy = 63.5f};
  out.vision.width = width;
  out.vision.height = height;
  return out;
}

Vo vo{sensors()};  // every byte it will ever use

float use_estimator(pl::TimeNs t_ns) {
  const pl::Result<pl::Estimate<float>> estimate =
      vo.add_frame({.t_ns = t_ns, .gray = {gray, width, height, width}, .depth = {depth, width, height, width}});
  return estimate ? estimate->T_world_body.p().x() : 0;
}

float use_camera() {
  const pl::AnyCamera<float> camera = pl::Pinhole<float>{.fx = 400, .fy = 400, .cx = 320, .cy = 240};
  const pl::SE3<float> T_world_cam = pl::SE3<float>::exp(pl::Vec<float, 6>::Constant(float(sensor_value)));
  const pl::Projection<float> seen = camera.project(T_world_cam.inverse() * pl::Vec<float, 3>(0, 0, 1));
  return seen.valid ? seen.uv.sum() + T_world_cam.log().sum() : 0;
}

}  // namespace

int main() { actuator_value = use_estimator(static_cast<pl::TimeNs>(sensor_value)) + use_camera(); }
