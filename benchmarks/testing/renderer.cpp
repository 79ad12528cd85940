#include "plumbline/testing/renderer.hpp"

#include <benchmark/benchmark.h>

#include <cstdint>

#include "plumbline/camera/pinhole.hpp"
#include "plumbline/testing/rig.hpp"
#include "plumbline/testing/scenes.hpp"
#include "plumbline/testing/simulated_camera.hpp"
#include "plumbline/testing/trajectory.hpp"

using namespace plumbline;
using namespace plumbline::testing;

namespace {

constexpr int width = 640, height = 480;
const Pinhole<double> camera{535, 535, 319.5, 239.5};

void renderer_render(benchmark::State& state, const char* name) {
  Renderer renderer(*make_scene(name), camera, width, height);
  const Trajectory trajectory = *Trajectory::for_scene(name);
  Image<float> gray(width, height), depth(width, height);
  double t = 0;
  for (auto _ : state)
    renderer.render(trajectory.at(t += 0.37).T_world_body * simulated_T_body_camera(), gray.view(), depth.view());
  state.SetItemsProcessed(state.iterations());
}

void simulated_camera_frame(benchmark::State& state, const char* name) {
  SimulatedCamera sensor(Renderer(*make_scene(name), camera, width, height), simulated_T_body_camera(), {}, 1);
  const Trajectory trajectory = *Trajectory::for_scene(name);
  std::uint64_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(sensor.frame(trajectory, 0.37 * static_cast<double>(i), i));
    ++i;
  }
  state.SetItemsProcessed(state.iterations());
}

}  // namespace

BENCHMARK_CAPTURE(renderer_render, room, "room")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(renderer_render, corridor, "corridor")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(simulated_camera_frame, room, "room")->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(simulated_camera_frame, room_lowtex, "room_lowtex")->Unit(benchmark::kMillisecond);

BENCHMARK_MAIN();
