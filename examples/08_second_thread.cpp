// A second thread: how long a frame's pose takes when the keyframe task runs beside the caller, and when it does
// not. Plays a recording with an IMU at the speed at which it was made, once each way.
//
//   example_08_second_thread <directory of a recording with IMU> [seconds of it]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <thread>
#include <variant>
#include <vector>

#include "plumbline/backend/direct_gauss_newton.hpp"
#include "plumbline/camera/any_camera.hpp"
#include "plumbline/estimator/estimator.hpp"
#include "plumbline/feature/features.hpp"
#include "plumbline/feature/lines.hpp"
#include "plumbline/feature/points.hpp"
#include "plumbline/io/make_camera.hpp"
#include "plumbline/io/recording.hpp"
#include "plumbline/opencv/image_file.hpp"
#include "plumbline/opencv/mat_view.hpp"
#include "plumbline/sensor/imu.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/thread/background_worker.hpp"

namespace pl = plumbline;

using Sensors = pl::Rig<pl::Mono<pl::AnyCamera<double>, 1280 * 800>, pl::Imu>;
using Features = pl::Features<pl::Points<250>, pl::Lines<100>>;
template <pl::Executor Task>
using Vio = pl::Estimator<Sensors, Features, pl::DirectGaussNewton<10>, pl::NoClock, pl::NoMap, Task>;

// An operating system without std::thread has an executor of its own: `start` wakes a task that calls run(context),
// `wait` sleeps until it has.
static_assert(pl::Executor<pl::BackgroundWorker>);

/// Time from a frame to its pose [ms].
struct Latency {
  std::vector<double> keyframes, others;
};

template <class Vio>
Latency play(const char* directory, double seconds) {
  using Clock = std::chrono::steady_clock;
  auto recording = pl::io::Recording::open(directory);
  const pl::io::Calibration& calibration = recording.calibration();
  Sensors sensors{};
  sensors.vision.camera = pl::io::make_camera<double>(calibration.camera);
  sensors.vision.width = calibration.camera.width;
  sensors.vision.height = calibration.camera.height;
  sensors.imu.T_body_cam = calibration.T_body_camera.value();
  sensors.imu.noise = calibration.imu.value();
  sensors.imu.limits = calibration.imu_limits;
  const auto vio = std::make_unique<Vio>(sensors);

  Latency latency;
  const pl::TimeNs first_ns = recording.frames().front().t_ns;
  const Clock::time_point start = Clock::now();
  for (pl::io::Recording::Sample sample; recording.next(sample);) {
    if (const auto* imu = std::get_if<pl::ImuSample>(&sample)) {
      (void)vio->add_imu(*imu);  // never waits for the keyframe task
      continue;
    }
    const auto& frame = std::get<pl::io::FrameSample>(sample);
    if (pl::seconds_between(first_ns, frame.t_ns) > seconds) break;
    const cv::Mat gray = pl::opencv::read_gray(frame.image);
    std::this_thread::sleep_until(start + std::chrono::nanoseconds(frame.t_ns - first_ns));
    const Clock::time_point begin = Clock::now();
    const auto estimate = vio->add_frame({frame.t_ns, pl::opencv::view<std::uint8_t>(gray)});
    const double ms = std::chrono::duration<double, std::milli>(Clock::now() - begin).count();
    if (!estimate || vio->init_report().stage != pl::InitStage::done) continue;
    (estimate->keyframe ? latency.keyframes : latency.others).push_back(ms);
  }
  return latency;
}

void print(const char* name, std::vector<double> ms) {
  if (ms.empty()) return;
  std::sort(ms.begin(), ms.end());
  const auto part = [&](double p) { return ms[std::size_t(p * double(ms.size() - 1))]; };
  std::printf("  %-10s %4zu  median %5.2f ms  99 %% %6.2f ms\n", name, ms.size(), part(0.5), part(0.99));
}

int main(int argc, char** argv) try {
  if (argc < 2) return std::fprintf(stderr, "usage: %s <directory of a recording with IMU> [seconds]\n", argv[0]), 1;
  const double seconds = argc > 2 ? std::atof(argv[2]) : 20;
  const Latency in_order = play<Vio<pl::SynchronousExecutor>>(argv[1], seconds);
  const Latency beside = play<Vio<pl::BackgroundWorker>>(argv[1], seconds);
  std::printf("one thread\n");
  print("keyframes", in_order.keyframes);
  print("others", in_order.others);
  std::printf("keyframe work on a second thread\n");
  print("keyframes", beside.keyframes);
  print("others", beside.others);
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
