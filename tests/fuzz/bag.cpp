// Any bytes as a bag: ROS 1, MCAP or SQLite, by their first bytes. Frames and IMU samples are ordered by time, samples
// are finite, images have pixels; or a std::runtime_error says in one line what is wrong.
#include <string_view>

#include "fuzz_folder.hpp"
#include "plumbline/io/bag/bag_recording.hpp"

namespace io = plumbline::io;

namespace {

/// Calls f; of what it throws only a std::runtime_error is right, in one line.
template <class F>
void expect_runtime_error_at_most(F&& f) {
  try {
    f();
  } catch (const std::runtime_error& error) {
    require(std::string_view(error.what()).find('\n') == std::string_view::npos, "an error is one line");
  }
}

template <class Items>
void require_increasing(const Items& items) {
  for (std::size_t i = 1; i < items.size(); ++i) require(items[i - 1].t_ns < items[i].t_ns, "times increase");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const TemporaryDirectory folder;
  const std::filesystem::path file = folder.write("a.bag", text_of(data, size));
  expect_read_error_at_most([&] {
    const io::Recording recording = io::bag::open_recording(file, {}, {});
    require(!recording.frames().empty(), "a recording has frames");
    require_increasing(recording.frames());
    require_increasing(recording.imu());
    for (const plumbline::ImuSample& sample : recording.imu())
      require(sample.gyro.allFinite() && sample.accel.allFinite(), "samples are finite");
    for (const io::FrameSample& frame : recording.frames()) {
      expect_runtime_error_at_most([&] {
        const cv::Mat gray = io::read_gray(frame);
        require(gray.type() == CV_8UC1 && !gray.empty(), "an image has gray pixels");
      });
      expect_runtime_error_at_most([&] {
        if (!frame.depth) return;
        const cv::Mat depth = io::read_depth(frame);
        require(depth.type() == CV_16UC1 && !depth.empty(), "depth has 16 bits");
      });
    }
  });
  return 0;
}
