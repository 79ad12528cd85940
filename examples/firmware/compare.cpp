// Compares the frames of the firmware with those of the host, and counts what the firmware needs.
//
//   firmware_compare <lines of the host> <lines of the firmware> <largest distance of positions [m]; 0: equal bits>
//
// Writes "name=value" for each figure to stdout. Fails where a frame's health differs, a position differs by more
// or a bit at all, or fewer than ten frames have the state `tracking`.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <numeric>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "plumbline/state/health.hpp"

namespace {

constexpr double instructions_per_tick = 40;  // 25 MHz against one instruction in a nanosecond: qemu -icount shift=0

struct Lines {
  std::vector<std::vector<std::uint64_t>> frames;  ///< numbers of each line
  std::vector<std::uint64_t> end;
};

Lines read(const char* file) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(std::string(file) + ": cannot be read");
  Lines out;
  int count = 0;
  for (std::string line; std::getline(in, line);) {
    ++count;
    std::istringstream words(line);
    std::string name;
    words >> name >> std::hex;
    std::vector<std::uint64_t> numbers;
    for (std::uint64_t number = 0; words >> number;) numbers.push_back(number);
    if (name == "frame" && numbers.size() == 13) {
      out.frames.push_back(numbers);
    } else if (name == "end" && numbers.size() == 4) {
      out.end = numbers;
    } else {
      throw std::runtime_error(std::string(file) + ":" + std::to_string(count) + ": unexpected: " + line);
    }
  }
  if (out.frames.empty() || out.end.empty()) throw std::runtime_error(std::string(file) + ": the end is missing");
  return out;
}

float number(std::uint64_t bits) { return std::bit_cast<float>(static_cast<std::uint32_t>(bits)); }

double distance(const std::vector<std::uint64_t>& a, const std::vector<std::uint64_t>& b) {
  return std::hypot(number(a[4]) - number(b[4]), number(a[5]) - number(b[5]), number(a[6]) - number(b[6]));
}

void print_million(const char* name, std::vector<std::uint64_t> ticks) {
  if (ticks.empty()) ticks.push_back(0);
  std::sort(ticks.begin(), ticks.end());
  const double unit = instructions_per_tick * 1e-6, n = double(ticks.size());
  std::printf("%s_median=%.1f\n%s_mean=%.1f\n%s_longest=%.1f\n", name, unit * double(ticks[ticks.size() / 2]), name,
              unit * double(std::accumulate(ticks.begin(), ticks.end(), std::uint64_t(0))) / n, name,
              unit * double(ticks.back()));
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc != 4) return std::fprintf(stderr, "usage: %s <host> <firmware> <largest distance>\n", argv[0]), 1;
  const Lines host = read(argv[1]), firmware = read(argv[2]);
  const double largest = std::atof(argv[3]);
  const auto fail = [](std::size_t frame, const char* what) {
    throw std::runtime_error("frame " + std::to_string(frame + 1) + ": " + what);
  };
  if (host.frames.size() != firmware.frames.size()) throw std::runtime_error("other numbers of frames");
  double farthest = 0;
  std::size_t equal = 0, tracking = 0, same_keyframes = 0;
  bool all_equal = true;
  std::vector<std::uint64_t> frame_ticks, tracking_ticks, idle_ticks;
  for (std::size_t i = 0; i < host.frames.size(); ++i) {
    const auto &a = host.frames[i], &b = firmware.frames[i];
    if (!std::equal(a.begin(), a.begin() + 3, b.begin())) fail(i, "time stamp or health differs from the host's");
    same_keyframes += a[3] == b[3];
    farthest = std::max(farthest, distance(a, b));
    if (!(farthest <= largest)) fail(i, ("position differs by " + std::to_string(farthest) + " m").c_str());
    all_equal = all_equal && std::equal(a.begin(), a.begin() + 11, b.begin());
    equal += all_equal;
    if (largest == 0 && !all_equal) fail(i, "bits differ from the host's");
    const bool has_pose = b[1] != std::uint64_t(plumbline::HealthState::initializing);
    tracking += b[1] == std::uint64_t(plumbline::HealthState::tracking);
    frame_ticks.push_back(b[11]);
    if (has_pose) tracking_ticks.push_back(b[11]);
    if (b[12] > 0) idle_ticks.push_back(b[12]);
  }
  std::printf("frames=%zu\ntracking=%zu\nequal_frames=%zu\nsame_keyframes=%zu\nlargest_distance_m=%.1e\n",
              host.frames.size(), tracking, equal, same_keyframes, farthest);
  print_million("frame", frame_ticks);
  print_million("posed", tracking_ticks);
  print_million("idle", idle_ticks);
  std::printf("estimator_bytes=%llu\nstack_bytes=%llu\nrefused=%llu\nqueue_full=%llu\n",
              static_cast<unsigned long long>(firmware.end[0]), static_cast<unsigned long long>(firmware.end[1]),
              static_cast<unsigned long long>(firmware.end[2]), static_cast<unsigned long long>(firmware.end[3]));
  if (firmware.end[2] != host.end[2]) throw std::runtime_error("other numbers of refused IMU samples");
  if (tracking < 10) throw std::runtime_error("fewer than ten frames in the state tracking");
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
