// Visual-inertial odometry on a Cortex-M7 without operating system. SysTick stands for the IMU's data-ready interrupt
// and takes its samples from the recording; the main loop takes the images from there and does keyframe work when idle.
#include <algorithm>
#include <cstdint>
#include <new>

#include "board.hpp"
#include "frame_line.hpp"
#include "idle_executor.hpp"
#include "imu_queue.hpp"
#include "vio.hpp"

namespace {

using FirmwareVio = Vio<IdleExecutor>;

const Recording recording(reinterpret_cast<const void*>(0x60000000));

// Every byte that the estimator will ever use. It is constructed in main: no guard, no order of constructors.
[[gnu::section(".arena")]] alignas(FirmwareVio) unsigned char arena[sizeof(FirmwareVio)];

// The recording is played at this part of its speed: two instructions in a nanosecond of its time.
constexpr double slowdown = 2;

ImuQueue<256> queue;
volatile int next_sample = 0;           // of the recording; written by the interrupt alone
volatile std::uint32_t full_count = 0;  // the recording waits then; a sensor would lose the sample

}  // namespace

void board::on_tick() {
  const int i = next_sample;
  if (i == recording.samples()) return;
  if (queue.push(recording.sample(i))) {
    next_sample = i + 1;
  } else {
    full_count = full_count + 1;
  }
}

int main() {
  board::start();
  LineWriter line(board::write);
  if (!recording.is_valid()) {
    line.begin("no recording at 60000000");
    line.end();
    board::exit(2);
  }
  FirmwareVio& vio = *new (arena) FirmwareVio(make_sensors(recording.header()));
  board::paint_stack();
  board::start_ticks(std::uint32_t(recording.header().rate_hz / slowdown));

  std::uint32_t refused = 0;
  plumbline::TimeNs last_sample_ns = 0;
  for (int i = 0; i < recording.frames(); ++i) {
    const Sensors::Frame frame = recording.frame<Sensors>(i);
    std::uint32_t idle_ticks = 0;
    while (!is_due(frame.t_ns, last_sample_ns)) {
      plumbline::ImuSample sample;
      const std::uint32_t begin = board::ticks();
      if (queue.pop(sample)) {
        refused += !vio.add_imu(sample);
        last_sample_ns = sample.t_ns;
      } else if (vio.executor().work()) {
        idle_ticks += board::ticks() - begin;
      } else {
        board::wait_for_interrupt();
      }
    }
    const std::uint32_t begin = board::ticks();
    const auto estimate = vio.add_frame(frame);
    if (!estimate) board::exit(5);
    line.frame(*estimate, board::ticks() - begin, idle_ticks);
  }
  line.begin("end");
  line.hex(sizeof(FirmwareVio));
  line.hex(board::used_stack());
  line.hex(refused);
  line.hex(full_count);
  line.end();
}
