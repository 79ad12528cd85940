// Any bytes as a trajectory: the first byte chooses the name of the file; poses are finite and ordered by time.
#include "plumbline/io/trajectory.hpp"
#include "fuzz_folder.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryDirectory folder;
  if (size == 0) return 0;
  folder.write("times.txt", "0\n0.1\n0.2\n0.3\n");  // of KITTI
  const char* names[] = {"groundtruth.txt", "data.csv", "poses.txt"};
  const std::filesystem::path file = folder.write(names[data[0] % 3], text_of(data + 1, size - 1));
  expect_read_error_at_most([&] {
    plumbline::TimeNs last = std::numeric_limits<plumbline::TimeNs>::min();
    for (const auto& pose : plumbline::io::read_trajectory(file)) {
      require(pose.t_ns > last, "times increase");
      last = pose.t_ns;
    }
  });
  return 0;
}
