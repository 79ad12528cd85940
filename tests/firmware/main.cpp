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

float use_camera() {
  const pl::Pinhole<float> camera{.fx = 400, .fy = 400, .cx = 320, .cy = 240};
  const pl::SE3<float> T_world_cam = pl::SE3<float>::exp(pl::Vec<float, 6>::Constant(float(sensor_value)));
  const pl::Projection<float> seen = camera.project(T_world_cam.inverse() * pl::Vec<float, 3>(0, 0, 1));
  return seen.valid ? seen.uv.sum() + T_world_cam.log().sum() : 0;
}

}  // namespace

int main() { actuator_value = use_camera(); }
