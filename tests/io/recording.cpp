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
  const std::vector<std::string> notes = Recording::open(directory.path()).notes();
  REQUIRE(
      (notes.size() == 1 && notes[0].find("1 of 3 rows is skipped: the image does not exist: ") != std::string::npos));
  REQUIRE(notes[0].ends_with("image_0/000002.png (or .jpg) (line 3)"));
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
  directory.write("rgb.txt", "10.0 rgb/8.png\n10.1 rgb/9.png\n10.2 rgb/0.png\n");
  require_error(directory, "rgb.txt", 1,
                "the image does not exist: " + (directory.path() / "rgb/8.png").string() + " (2 of 3 rows)");
  directory.write("rgb.txt", "10.3 rgb/0.png\n10.0 rgb/1.png\n10.1 rgb/2.png\n");
  require_error(directory, "rgb.txt", 2, "before that of the row above (2 of 3 rows)");
  directory.write("rgb.txt", "10.0 rgb/0.png\n10.0 rgb/1.png\n10.0 rgb/2.png\n");
  require_error(directory, "rgb.txt", 2, "that of the row above (2 of 3 rows)");
  directory.write("rgb.txt", "10.0\n");
  require_error(directory, "rgb.txt", 1, "expected 2 columns, found 1");
  directory.write("rgb.txt", "ten rgb/0.png\n");
  require_error(directory, "rgb.txt", 1, "\"ten\" is not a time stamp");
  directory.write("rgb.txt", "# nothing\n");
  require_error(directory, "rgb.txt", 0, "names no images");
  write_tum(directory);
  directory.write("depth.txt", "10.0 depth/7.png\n");
  require_error(directory, "depth.txt", 1, "depth/7.png");
}

TEST_CASE("recording: faults of the IMU file") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("imu.csv", "1 0 0 0 0 0\n2 0 0 0 0 0\n3 0 0 0 0 0 9.81\n");
  require_error(directory, "imu.csv", 1, "expected 7 columns, found 6 (2 of 3 rows)");
  directory.write("imu.csv", "1 0 0 0 0 0 9.81\n2 0 0 nan 0 0 9.81\n3 0 0 nan 0 0 9.81\n");
  require_error(directory, "imu.csv", 2, "a value is not finite: column 4 (2 of 3 rows)");
  directory.write("imu.csv", "1 0 0 0 0 0 9.81\n2 0 0 x 0 0 9.81\n");
  require_error(directory, "imu.csv", 2, "column 4: \"x\" is not a finite number");
  directory.write("imu.csv", "");
  require_error(directory, "imu.csv", 0, "has no IMU samples");
}

TEST_CASE("recording: no calibration") {
  const TemporaryDirectory directory;
  write_tum(directory);
  std::filesystem::remove(directory.path() / "calibration.yaml");
  require_error(directory, "calibration.yaml", 0, "no such file: the recording has no calibration of its own");
}

namespace {

const std::string camchain =
    "cam0:\n  T_cam_imu:\n  - [1, 0, 0, 0]\n  - [0, 1, 0, 0]\n  - [0, 0, 1, 0]\n  - [0, 0, 0, 1]\n"
    "  camera_model: pinhole\n  intrinsics: [500, 500, 320, 240]\n  resolution: [640, 480]\n"
    "  distortion_model: none\n";
const std::string imu_noise =
    "rate_hz: 123\ngyroscope_noise_density: 1e-4\ngyroscope_random_walk: 2e-5\n"
    "accelerometer_noise_density: 3e-3\naccelerometer_random_walk: 4e-3\n";

bool has_note(const Recording& recording, const std::string& text) {
  for (const std::string& note : recording.notes()) {
    UNSCOPED_INFO(note);
    if (note.find(text) != std::string::npos) return true;
  }
  return false;
}

}  // namespace

TEST_CASE("recording: the noise of the IMU from a file beside the camera's calibration, or by option") {
  const TemporaryDirectory directory;
  write_tum(directory);
  const auto chain = directory.write("kalibr/camchain.yaml", camchain);
  REQUIRE(!Recording::open(directory.path(), {.calibration = chain}).has_imu());
  directory.write("kalibr/broken.yaml", "a: [");
  directory.write("kalibr/camchain2.yaml", camchain + "imu0:\n  gyroscope_noise_density: 1\n");
  const auto imu_file = directory.write("kalibr/imu.yaml", imu_noise);
  const Recording beside = Recording::open(directory.path(), {.calibration = chain, .depth_scale = 1000});
  REQUIRE((beside.has_imu() && beside.calibration().imu->rate_hz == 123 && beside.has_depth()));
  REQUIRE(has_note(beside, "kalibr/imu.yaml: the noise of the IMU is taken from this file"));
  const auto inputs = beside.inputs();
  REQUIRE(std::count(inputs.begin(), inputs.end(), imu_file) == 1);
  directory.write("kalibr/imu2.yaml", imu_noise);
  const Recording several = Recording::open(directory.path(), {.calibration = chain});
  REQUIRE((!several.has_imu() && has_note(several, "(imu.yaml, imu2.yaml); choose with --imu-calibration")));
  REQUIRE(Recording::open(directory.path(), {.calibration = chain, .imu_calibration = imu_file}).has_imu());
  // The option is stronger than what the calibration states.
  REQUIRE(
      Recording::open(directory.path(), {.calibration = {}, .imu_calibration = imu_file}).calibration().imu->rate_hz ==
      123);
}

TEST_CASE("recording: TUM-VI, with its calibration in dso/ and its truth in mocap0/") {
  const TemporaryDirectory directory;
  write_euroc(directory);
  std::filesystem::remove(directory.path() / "mav0/cam0/sensor.yaml");
  std::filesystem::remove(directory.path() / "mav0/imu0/sensor.yaml");
  std::filesystem::rename(directory.path() / "mav0/state_groundtruth_estimate0", directory.path() / "mav0/mocap0");
  directory.write("mav0/cam1/data.csv", "");
  directory.write("dso/camchain.yaml", camchain);
  directory.write("dso/imu_config.yaml", imu_noise);
  const Recording recording = Recording::open(directory.path());
  REQUIRE((recording.has_imu() && recording.read_groundtruth(true)->size() == 1));
  REQUIRE(recording.files().other_sensors.size() == 1);
}

TEST_CASE("recording: rows that cannot be used are skipped, counted and said once") {
  const TemporaryDirectory directory;
  write_tum(directory);
  directory.write("rgb.txt",
                  "10.00 rgb/0.png\n10.05 rgb/missing.png\n10.10 rgb/1.png\n10.10 rgb/1.png\n10.02 rgb/2.png\n"
                  "10.20 rgb/2.png\n10.30 rgb/3.png\n10.35\n");
  std::string rows;
  for (int i = 0; i < 15; ++i) {
    const std::string t = std::to_string(9.90 + 0.04 * i);
    rows += t + " 0 0 " + std::to_string(i) + " 0 0 9.81\n";
    if (i % 5 == 0) rows += t + " 0 0 0 0 0 9.81\n";
  }
  directory.write("imu.csv", rows + "10.47 0 0 nan 0 0 9.81\n10.48 0 0 0 0 -inf 9.81\n");
  const Recording recording = Recording::open(directory.path());
  REQUIRE((recording.frame_count() == 4 && recording.notes().size() == 6));
  REQUIRE(has_note(recording, "rgb.txt: 1 of 8 rows is skipped: the image does not exist: "));
  REQUIRE(has_note(recording, "rgb/missing.png (line 2)"));
  REQUIRE(has_note(recording, "1 of 8 rows is skipped: the time stamp is that of the row above (line 4)"));
  REQUIRE(has_note(recording, "1 of 8 rows is skipped: the time stamp is before that of the row above (line 5)"));
  REQUIRE(has_note(recording, "1 of 8 rows is skipped: expected 2 columns, found 1 (line 8)"));
  REQUIRE(has_note(recording,
                   "imu.csv: 3 of 20 rows are skipped: the time stamp is that of the row above (first: line 2)"));
  REQUIRE(has_note(recording, "imu.csv: 2 of 20 rows are skipped: a value is not finite: column 4 (first: line 19)"));
}

TEST_CASE("recording: headers without #, a byte order mark, more columns") {
  const TemporaryDirectory directory;
  write_euroc(directory);
  directory.write("mav0/cam0/data.csv",
                  "\xEF\xBB\xBFtimestamp [ns],filename\r\n1000000000,a.jpg,7\r\n1100000000,b.jpg,8\r\n");
  directory.write("mav0/imu0/data.csv",
                  "Time,wx,wy,wz,ax,ay,az,temperature\n1000000000,1,2,3,4,5,6,20\n1100000000,1,2,3,4,5,6,20\n");
  const Recording recording = Recording::open(directory.path());
  REQUIRE((recording.frame_count() == 2 && recording.imu().size() == 2 && recording.notes().size() == 2));
  REQUIRE(has_note(recording, "cam0/data.csv:2: found 3 columns, those after column 2 are ignored"));
  REQUIRE(has_note(recording, "imu0/data.csv:2: found 8 columns, those after column 7 are ignored"));
  directory.write("mav0/imu0/data.csv", "\xFF\xFEt");
  require_error(directory, "mav0/imu0/data.csv", 1, "the text is UTF-16: save it as UTF-8");
}

TEST_CASE("recording: units of time stamps are recognized and said") {
  const TemporaryDirectory directory;
  write_euroc(directory);
  directory.write("mav0/cam0/data.csv", "1600000000.05,a.jpg\n1600000000.15,b.jpg\n");
  directory.write("mav0/imu0/data.csv", "1600000000050,1,2,3,4,5,6\n1600000000055.25,1,2,3,4,5,6\n");
  Recording recording = Recording::open(directory.path());
  REQUIRE((recording.frames()[0].t_ns == 1600000000050000000 && recording.imu()[1].t_ns == 1600000000055250000));
  REQUIRE(has_note(recording, "cam0/data.csv: the time stamps are in seconds (expected nanoseconds)"));
  REQUIRE(has_note(recording, "imu0/data.csv: the time stamps are in milliseconds (expected nanoseconds)"));
  // Times since the sensor began are in the layout's unit.
  directory.write("mav0/cam0/data.csv", "600000000000,a.jpg\n600050000000,b.jpg\n");
  directory.write("mav0/imu0/data.csv", "600000000000,1,2,3,4,5,6\n600005000000,1,2,3,4,5,6\n");
  recording = Recording::open(directory.path());
  REQUIRE((recording.frames()[1].t_ns == 600050000000 && recording.notes().empty()));
}

namespace {

/// Gyroscope at 100 Hz with x = t, accelerometer at 40 Hz with x = 10 t, in files of their own; t from 9.9 s.
void write_separate_sensors(const TemporaryDirectory& directory, const std::string& gyro_file,
                            const std::string& accel_file) {
  const auto rows = [](int n, double period_s, double factor) {
    std::string out = "timestamp,x,y,z\n";
    for (int i = 0; i < n; ++i) {
      const double t = 9.9 + period_s * i;
      out += std::to_string(t) + "," + std::to_string(factor * t) + ",0,1\n";
    }
    return out;
  };
  directory.write(gyro_file, rows(60, 0.01, 1));
  directory.write(accel_file, rows(22, 0.025, 10));
}

}  // namespace

TEST_CASE("recording: gyroscope and accelerometer in files of their own") {
  for (const auto& [gyro, accel] : {std::pair("gyro.csv", "accel.csv"), {"gyroscope.txt", "accelerometer.txt"}}) {
    const TemporaryDirectory directory;
    write_tum(directory);
    std::filesystem::remove(directory.path() / "imu.csv");
    write_separate_sensors(directory, gyro, accel);
    const Recording recording = Recording::open(directory.path());
    CAPTURE(gyro);
    REQUIRE(recording.has_imu());
    REQUIRE(recording.imu().size() > 40);
    for (const ImuSample& sample : recording.imu()) {
      const double t = 1e-9 * double(sample.t_ns);
      CHECK(sample.gyro.x() == Approx(t).margin(1e-4));
      CHECK(sample.accel.x() == Approx(10 * t).margin(1e-3));
    }
    // The accelerometer ends at 10.425 s: the samples of the gyroscope after it are left out.
    CHECK(recording.imu().back().t_ns == 10'420'000'000);
    const auto notes = recording.notes();
    CHECK(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.find("the accelerometer has 40 Hz, interpolated to the times of the gyroscope (100 Hz); 7 of 60") !=
             std::string::npos;
    }));
    CHECK(recording.files().held_accel.rate_hz == Approx(40).epsilon(0.01));
    const auto inputs = recording.inputs();
    CHECK(std::find(inputs.begin(), inputs.end(), directory.path() / accel) != inputs.end());
  }
}

TEST_CASE("recording: one sensor of the IMU without the other, and sensors of two clocks") {
  const TemporaryDirectory directory;
  write_tum(directory);
  std::filesystem::remove(directory.path() / "imu.csv");
  write_separate_sensors(directory, "gyro.csv", "accel.csv");
  directory.write("accel.csv", "1000 0 0 9.81\n1000.01 0 0 9.81\n");
  const std::string message = message_of([&] { Recording::open(directory.path()); });
  CHECK(reports(message, directory.path() / "accel.csv", 0, "do both have the same clock and unit of time?"));
  std::filesystem::remove(directory.path() / "accel.csv");
  const Recording alone = Recording::open(directory.path());
  CHECK(!alone.has_imu());
  CHECK(alone.notes().at(0).find("gyro.csv is not used: there is no file of the accelerometer beside it") !=
        std::string::npos);
}

TEST_CASE("recording: KITTI raw with oxts as IMU") {
  const TemporaryDirectory day;
  const std::string drive = "2011_09_26_drive_0001/";
  std::string frames, samples;
  for (int i = 0; i < 4; ++i) {
    const std::string number = "000000000" + std::to_string(i);
    frames += "2011-09-26 13:02:25.";
    frames += std::to_string(1 + 2 * i);
    frames += "00000001\n";
    if (i != 2) day.write(drive + "image_00/data/" + number + ".png", "");
  }
  for (int i = 0; i < 10; ++i) {
    std::string row;
    for (int k = 0; k < 30; ++k) row += std::to_string(k + 100 * i) + " ";
    day.write(drive + "oxts/data/000000000" + std::to_string(i) + ".txt", row + "\n");
    samples += "2011-09-26 13:02:25.0" + std::to_string(i) + "0000000\n";
  }
  day.write(drive + "image_00/timestamps.txt", frames);
  day.write(drive + "image_01/timestamps.txt", frames);
  day.write(drive + "oxts/timestamps.txt", samples);
  day.write("calib_cam_to_cam.txt",
            "calib_time: 09-Jan-2012 13:57:47\nR_rect_00: 1 0 0 0 1 0 0 0 1\nS_rect_00: 1242 375\n"
            "P_rect_00: 721 0 609 0 0 721 172 0 0 0 1 0\n");
  const Recording recording = Recording::open(day.path() / drive);
  REQUIRE(recording.layout() == Layout::kitti_raw);
  REQUIRE(recording.frame_count() == 3);
  CHECK(recording.frames()[0].t_ns == 1'317'042'145'100'000'001);  // date -u -d '2011-09-26 13:02:25' +%s
  CHECK(recording.frames()[2].image.filename() == "0000000003.png");
  CHECK(recording.calibration().camera.width == 1242);
  CHECK(recording.files().other_sensors.size() == 1);
  const ImuSample& last = recording.imu().back();
  CHECK(last.gyro == Vec<double, 3>(917, 918, 919));
  CHECK(last.accel == Vec<double, 3>(911, 912, 913));
  CHECK(last.t_ns == 1'317'042'145'090'000'000);
  const auto notes = recording.notes();
  CHECK(notes.at(0).find("1 of 4 rows is skipped: the image does not exist") != std::string::npos);

  day.write(drive + "image_00/timestamps.txt", "2011-09-26 13:02\n");
  const std::string message = message_of([&] { Recording::open(day.path() / drive); });
  CHECK(reports(message, day.path() / drive / "image_00/timestamps.txt", 1, "is no time stamp of the form"));
}
