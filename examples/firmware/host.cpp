// The same estimator on the host: writes the same lines as the firmware.
//
//   firmware_host <packed recording>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <vector>

#include "frame_line.hpp"
#include "vio.hpp"

int main(int argc, char** argv) {
  if (argc != 2) return std::fprintf(stderr, "usage: %s <packed recording>\n", argv[0]), 1;
  std::ifstream file(argv[1], std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  std::vector<std::uint64_t> memory((bytes.size() + 7) / 8 + sizeof(RecordingHeader));  // aligned
  std::copy(bytes.begin(), bytes.end(), reinterpret_cast<char*>(memory.data()));
  const Recording recording(memory.data());
  if (!recording.is_valid()) return std::fprintf(stderr, "%s: not a packed recording\n", argv[1]), 1;

  using HostVio = Vio<plumbline::SynchronousExecutor>;
  const auto vio = std::make_unique<HostVio>(make_sensors(recording.header()));
  LineWriter line([](char c) { std::putchar(c); });
  std::uint32_t refused = 0;
  plumbline::TimeNs last_sample_ns = 0;
  int next = 0;
  for (int i = 0; i < recording.frames(); ++i) {
    const Sensors::Frame frame = recording.frame<Sensors>(i);
    for (; !is_due(frame.t_ns, last_sample_ns) && next < recording.samples(); ++next) {
      refused += !vio->add_imu(recording.sample(next));
      last_sample_ns = recording.sample(next).t_ns;
    }
    const auto estimate = vio->add_frame(frame);
    if (!estimate) return std::fprintf(stderr, "frame %d: %s\n", i, name_of(estimate.error())), 1;
    line.frame(*estimate, 0, 0);
  }
  line.begin("end");
  line.hex(sizeof(HostVio));
  line.hex(0);
  line.hex(refused);
  line.hex(0);
  line.end();
}
