#include "plumbline/io/recording.hpp"

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline;
using namespace plumbline::io;

namespace {

const std::string camera = "camera:\n  model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  resolution: [640, 480]\n";
const std::string imu = R"(T_body_camera: [0, 0, 1, 0.5, -1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 0, 1]
imu:
  rate_hz: 200
  gyroscope_noise_density: 1e-4
  gyroscope_random_walk: 2e-5
  accelerometer_noise_density: 3e-3
  accelerometer_random_walk: 4e-3
)";

/// TUM RGB-D: 4 frames at 0.1 s, depth 5 ms later, none for frame 2; IMU at 40 ms.
void write_tum(const TemporaryDirectory& directory) {
  directory.write("rgb.txt", "# color\n10.00 rgb/0.png\n10.10 rgb/1.png\n10.20 rgb/2.png\n10.30 rgb/3.png\n");
  directory.write("depth.txt", "10.005 depth/0.png\n10.105 depth/1.png\n10.25 depth/x.png\n10.305 depth/3.png\n");
  for (const char* name :
       {"rgb/0.png", "rgb/1.png", "rgb/2.png", "rgb/3.png", "depth/0.png", "depth/1.png", "depth/x.png", "depth/3.png"})
    directory.write(name, "");
  std::string rows;
  for (int i = 0; i < 15; ++i) rows += std::to_string(9.90 + 0.04 * i) + " 0 0 " + std::to_string(i) + " 0 0 9.81\n";
  directory.write("imu.csv", rows);
  directory.write("calibration.yaml", camera + "depth:\n  scale: 5000\n" + imu);
}

void write_euroc(const TemporaryDirectory& directory) {
  directory.write("mav0/cam0/data.csv", "#timestamp [ns],filename\r\n1000000000,a.jpg\r\n1100000000,b.jpg\r\n");
  directory.write("mav0/cam0/data/a.jpg", "");
  directory.write("mav0/cam0/data/b.jpg", "");
  directory.write(
      "mav0/imu0/data.csv",
      "#t\n1000000000,1,2,3,4,5,6\n1050000000,1,2,3,4,5,6\n1100000000,1,2,3,4,5,6\n1150000000,1,2,3,4,5,6\n");
  directory.write(
      "mav0/cam0/sensor.yaml",
      "T_BS: [1, 0, 0, 0.5, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]\nresolution: [640, 480]\ncamera_model: pinhole\n"
      "intrinsics: [500, 500, 320, 240]\ndistortion_model: none\ndistortion_coefficients: []\n");
  directory.write("mav0/imu0/sensor.yaml",
                  "rate_hz: 20\ngyroscope_noise_density: 1e-4\ngyroscope_random_walk: 2e-5\n"
                  "accelerometer_noise_density: 3e-3\naccelerometer_random_walk: 4e-3\n");
  directory.write("mav0/state_groundtruth_estimate0/data.csv", "1000000000,1,2,3,1,0,0,0\n");
}

/// The stream as text: i for an IMU sample, F for a frame with depth, f for one without.
std::string order(Recording& recording) {
  std::string out;
  for (Recording::Sample sample; recording.next(sample);) {
    const FrameSample* frame = std::get_if<FrameSample>(&sample);
    out += frame == nullptr ? 'i' : frame->depth ? 'F' : 'f';
  }
  return out;
}

void require_error(const TemporaryDirectory& directory, const std::string& name, int line, const std::string& what) {
  const std::string message = message_of([&] { Recording::open(directory.path()); });
  CAPTURE(message, line, what);
  REQUIRE(reports(message, name.empty() ? directory.path() : directory.path() / name, line, what));
}

}  // namespace

TEST_CASE("recording: TUM, merged in order of time with one IMU sample beyond each frame") {
  const TemporaryDirectory directory;
  write_tum(directory);
  Recording recording = Recording::open(directory.path());
  REQUIRE((recording.layout() == Layout::tum && recording.frame_count() == 4));
  REQUIRE((recording.has_imu() && recording.has_depth()));
  // IMU from 9.98 on: 9.98 10.02 | 10.06 10.10 | 10.14 10.18 10.22 | 10.26 10.30
  REQUIRE(order(recording) == "iiFiiFiiifiiF");
  recording.rewind();
  Recording::Sample sample;
  REQUIRE(recording.next(sample));
  REQUIRE((std::get<ImuSample>(sample).t_ns == 9980000000 && std::get<ImuSample>(sample).gyro.z() == 2));
  REQUIRE(std::get<ImuSample>(sample).accel.z() == 9.81);
  REQUIRE(recording.frames()[1].depth->filename() == "1.png");
}

TEST_CASE("recording: all that it consists of") {
  const TemporaryDirectory directory;
  write_tum(directory);
  const auto own = directory.write("own.yaml", camera + imu);
  const auto inputs = Recording::open(directory.path(), {.calibration = own}).inputs();
  for (const char* name : {"rgb.txt", "depth.txt", "imu.csv", "own.yaml", "rgb/3.png", "depth/0.png"}) {
    CAPTURE(name);
    REQUIRE(std::count(inputs.begin(), inputs.end(), directory.path() / name) == 1);
  }
  REQUIRE(std::count(inputs.begin(), inputs.end(), directory.path() / "calibration.yaml") == 0);
}

TEST_CASE("recording: a part of it") {
  const TemporaryDirectory directory;
  write_tum(directory);
  Recording recording = Recording::open(directory.path(), {.calibration = {}, .start_s = 0.1, .duration_s = 0.1});
  REQUIRE((recording.frame_count() == 2 && recording.frames()[0].t_ns == 10100000000));
  REQUIRE(order(recording) == "iFiiif");  // from the sample at 10.10 on
  const std::string message = message_of([&] { Recording::open(directory.path(), {.calibration = {}, .start_s = 7}); });
  REQUIRE(reports(message, directory.path(), 0, "no frame in the part asked for; the recording lasts 0.3 s"));
}

TEST_CASE("recording: frames in IMU time") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("calibration.yaml", camera + "  time_offset_s: -0.004\n" + imu);
  REQUIRE(Recording::open(directory.path()).frames()[0].t_ns == 9996000000);
}

TEST_CASE("recording: without IMU noise or depth scale there is neither") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("calibration.yaml", camera);
  Recording recording = Recording::open(directory.path());
  REQUIRE((!recording.has_imu() && !recording.has_depth() && recording.groundtruth() == std::nullopt));
  REQUIRE(order(recording).find('i') == std::string::npos);
}

TEST_CASE("recording: each depth image is used once") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("rgb.txt", "10.00 rgb/0.png\n10.01 rgb/1.png\n");
  Recording recording = Recording::open(directory.path());
  REQUIRE(!(recording.frames()[0].depth && recording.frames()[1].depth));
}

TEST_CASE("recording: EuRoC, with its ground truth for body and camera") {
  const TemporaryDirectory directory;
  write_euroc(directory);
  Recording recording = Recording::open(directory.path());
  REQUIRE((recording.layout() == Layout::euroc && recording.has_imu() && !recording.has_depth()));
  REQUIRE(order(recording) == "ifiif");
  REQUIRE(recording.read_groundtruth(true)->at(0).T_world_body.p() == Vec<double, 3>(1, 2, 3));
  REQUIRE(recording.read_groundtruth(false)->at(0).T_world_body.p() == Vec<double, 3>(1.5, 2, 3));
  const auto other = directory.write("other.yaml", camera + imu);
  REQUIRE(Recording::open(directory.path(), {.calibration = other}).calibration().imu->rate_hz == 200);
}

TEST_CASE("recording: KITTI") {
  const TemporaryDirectory directory;
  directory.write("times.txt", "0.0e+00\n1.037359e-01\n");
  directory.write("image_0/000000.png", "");
  directory.write("image_0/000001.jpg", "");
  directory.write("calibration.yaml", camera);
  Recording recording = Recording::open(directory.path());
  REQUIRE((recording.layout() == Layout::kitti && order(recording) == "ff"));
  REQUIRE(recording.frames()[1].image.filename() == "000001.jpg");
  directory.write("times.txt", "0.0e+00\n1.037359e-01\n2.0e-01\n");
  require_error(directory, "times.txt", 3, "000002.png (or .jpg) does not exist");
}

TEST_CASE("recording: places that hold none") {
  const TemporaryDirectory directory;
  require_error(directory, "", 0, "the directory is empty");
  const auto file = directory.write("notes.txt", "");
  require_error(directory, "", 0, "not a recording");
  REQUIRE(reports(message_of([&] { Recording::open(file); }), file, 0, "not a directory"));
  REQUIRE(reports(message_of([] { Recording::open("/nowhere"); }), "/nowhere", 0, "no such directory"));
}

TEST_CASE("recording: faults of the index files") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("rgb.txt", "10.0 rgb/0.png\n10.1 rgb/9.png\n");
  require_error(directory, "rgb.txt", 2, "rgb/9.png, which does not exist");
  directory.write("rgb.txt", "10.1 rgb/0.png\n10.0 rgb/1.png\n");
  require_error(directory, "rgb.txt", 2, "before that of the row above");
  directory.write("rgb.txt", "10.0 rgb/0.png\n10.0 rgb/1.png\n");
  require_error(directory, "rgb.txt", 2, "that of the row above");
  directory.write("rgb.txt", "10.0\n");
  require_error(directory, "rgb.txt", 1, "expected 2 columns, found 1");
  directory.write("rgb.txt", "ten rgb/0.png\n");
  require_error(directory, "rgb.txt", 1, "\"ten\" is not a time stamp");
  directory.write("rgb.txt", "# nothing\n");
  require_error(directory, "rgb.txt", 0, "names no images");
  write_tum(directory);
  directory.write("depth.txt", "10.0 depth/7.png\n");
  require_error(directory, "depth.txt", 1, "depth/7.png, which does not exist");
}

TEST_CASE("recording: faults of the IMU file") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("imu.csv", "1 0 0 0 0 0 9.81\n2 0 0 0 0 0\n");
  require_error(directory, "imu.csv", 2, "expected 7 columns, found 6");
  directory.write("imu.csv", "1 0 0 0 0 0 9.81\n2 0 0 nan 0 0 9.81\n");
  require_error(directory, "imu.csv", 2, "column 4: \"nan\" is not a finite number");
  directory.write("imu.csv", "1 0 0 0 0 0 9.81\n1 0 0 0 0 0 9.81\n");
  require_error(directory, "imu.csv", 2, "that of the row above");
  directory.write("imu.csv", "");
  require_error(directory, "imu.csv", 0, "has no IMU samples");
}

TEST_CASE("recording: no calibration") {
  const TemporaryDirectory directory;
  write_tum(directory);
  std::filesystem::remove(directory.path() / "calibration.yaml");
  require_error(directory, "calibration.yaml", 0, "no such file: the recording has no calibration of its own");
}
