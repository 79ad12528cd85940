// Any bytes as index files of a recording: the first byte chooses the layout, lines "=" separate the files. Frames and
// IMU samples are ordered by time, samples are finite.
#include <limits>
#include <string>

#include "fuzz_folder.hpp"
#include "plumbline/io/recording_layouts.hpp"

namespace {

struct Folders {
  TemporaryDirectory euroc, tum, kitti;

  Folders() {
    for (const char* name : {"1.png", "2.png", "3.png"}) {
      euroc.write(std::string("mav0/cam0/data/") + name, "");
      tum.write(std::string("rgb/") + name, "");
      tum.write(std::string("depth/") + name, "");
    }
    for (const char* name : {"000000.png", "000001.png", "000002.jpg"}) kitti.write(std::string("image_0/") + name, "");
  }
};

/// The text up to the next line "=", which is removed with it.
std::string_view next_file(std::string_view& text) {
  const std::size_t end = std::min(text.find("\n=\n"), text.size());
  const std::string_view file = text.substr(0, end);
  text.remove_prefix(std::min(end + 3, text.size()));
  return file;
}

template <class Items>
void require_increasing(const Items& items) {
  for (std::size_t i = 1; i < items.size(); ++i) require(items[i - 1].t_ns < items[i].t_ns, "times increase");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Folders folders;
  if (size == 0) return 0;
  std::string_view text = text_of(data + 1, size - 1);
  const TemporaryDirectory* folder = &folders.kitti;
  if (data[0] % 3 == 0) {
    folder = &folders.euroc;
    folder->write("mav0/cam0/data.csv", next_file(text));
    folder->write("mav0/imu0/data.csv", next_file(text));
  } else if (data[0] % 3 == 1) {
    folder = &folders.tum;
    folder->write("rgb.txt", next_file(text));
    folder->write("depth.txt", next_file(text));
    folder->write("imu.csv", next_file(text));
  } else {
    folder->write("times.txt", text);
  }
  expect_read_error_at_most([&] {
    const plumbline::io::RecordingFiles files = plumbline::io::read_layout(folder->path());
    require(!files.frames.empty(), "a recording has frames");
    require_increasing(files.frames);
    require_increasing(files.imu);
    for (const plumbline::ImuSample& sample : files.imu)
      require(sample.gyro.allFinite() && sample.accel.allFinite(), "samples are finite");
  });
  return 0;
}
