#include "plumbline/io/bag/bag_recording.hpp"

#include <string>
#include <vector>

#include "bag_writer.hpp"
#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::io;
using bag::Serialization;

TEST_CASE("a bag is a recording with frames, depth, IMU samples and the calibration of CameraInfo") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "robot";
  for (const test::BagFormat& format : test::bag_formats) {
    CAPTURE(format.name, format.compression);
    test::write_bag(file, format, test::robot_messages(format.serialization));
    const Recording recording = bag::open_recording(file, {}, {});
    REQUIRE(recording.layout() == Layout::bag);
    REQUIRE(recording.frame_count() == test::frames);
    REQUIRE(recording.imu().size() == 5 * test::frames);
    REQUIRE(recording.has_depth());
    REQUIRE(!recording.has_imu());  // no noise
    REQUIRE(recording.calibration().camera.intrinsics == std::vector<double>{16, 17, 16, 12});
    REQUIRE(recording.calibration().camera.distortion == "radtan");
    REQUIRE(recording.calibration().depth_scale == 1000);
    for (int i = 0; i < test::frames; ++i) {
      const FrameSample& frame = recording.frames()[static_cast<std::size_t>(i)];
      REQUIRE(frame.t_ns == test::frame_ns(i));
      const cv::Mat gray = read_gray(frame);
      REQUIRE(std::string(gray.ptr<char>(), gray.total()) == test::gray_pixels(i));
      const int byte = 4 + i;
      REQUIRE(read_depth(frame).at<std::uint16_t>(5, 5) == byte * 257);
    }
    REQUIRE(recording.inputs() == std::vector<std::filesystem::path>{file});
  }
}

TEST_CASE("topics are chosen where several fit") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "robot.bag";
  const auto s = Serialization::ros1;
  auto messages = test::robot_messages(s);
  for (int i = 0; i < test::frames; ++i)
    messages.push_back(
        {0, "/cam1/image_raw", "Image",
         test::image_message(s, test::frame_ns(i), test::width, test::height, "mono8", test::gray_pixels(100 + i))});
  test::write_bag(file, {"ros1", "lz4", s}, messages);
  const auto refusal = [&](const bag::TopicChoice& choice) {
    return message_of([&] { bag::open_recording(file, choice, {}); });
  };
  REQUIRE(
      reports(refusal({}), file, 0,
              "several topics (messages) fit, choose with --image-topic: /cam/image_raw (12), /cam1/image_raw (12)"));
  REQUIRE(reports(refusal({.image = "/cam2", .depth = {}, .imu = {}, .camera_info = {}}), file, 0,
                  "--image-topic /cam2: no such topic"));
  const Recording second =
      bag::open_recording(file, {.image = "/cam1/image_raw", .depth = "none", .imu = "none", .camera_info = {}}, {});
  const cv::Mat gray = read_gray(second.frames().front());
  REQUIRE(std::string(gray.ptr<char>(), gray.total()) == test::gray_pixels(100));
  REQUIRE(second.imu().empty());
  REQUIRE(!second.has_depth());
  REQUIRE(second.notes().back().find("/cam1/image_raw (12), /cam/camera_info (1)") != std::string::npos);
}

TEST_CASE("what is not used of a bag is said") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "robot.db3";
  const auto s = Serialization::cdr;
  auto messages = test::robot_messages(s, false);
  messages.push_back({0, "/imu", "Imu", test::imu_message(s, test::begin_ns, 0, 9.81)});  // a time that is there
  messages.push_back({0, "/imu", "Imu", "short"});
  std::swap(messages[20], messages[40]);  // out of order
  test::write_bag(file, {"sqlite", "", s}, messages);
  const Recording recording = bag::open_recording(file, {}, {});
  REQUIRE(recording.imu().size() == 5 * test::frames);
  const std::string note = recording.notes().front();
  REQUIRE(note.starts_with(file.string() + " /imu: 2 of 62 messages are skipped (first: message 62 "));

  auto without = test::robot_messages(s, false);
  std::erase_if(without, [](const auto& message) { return message.type == "CameraInfo"; });
  test::write_bag(file, {"sqlite", "", s}, without);
  REQUIRE(reports(message_of([&] { bag::open_recording(file, {}, {}); }), file, 0, "has no calibration"));
  std::erase_if(without, [](const auto& message) { return message.type == "Image"; });
  test::write_bag(file, {"sqlite", "", s}, without);
  REQUIRE(reports(message_of([&] { bag::open_recording(file, {}, {}); }), file, 0, "has no images"));
}

TEST_CASE("calibration and truth may lie beside a bag") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "robot.mcap";
  test::write_bag(file, {"mcap", "lz4", Serialization::cdr}, test::robot_messages(Serialization::cdr));
  directory.write("robot.calibration.yaml",
                  "camera:\n  model: pinhole\n  intrinsics: [20, 20, 16, 12]\n  resolution: [32, 24]\n");
  directory.write("groundtruth.txt", "1600000000.0 0 0 0 0 0 0 1\n");
  const Recording recording = bag::open_recording(file, {}, {});
  REQUIRE(recording.calibration().camera.intrinsics[0] == 20);
  REQUIRE(recording.groundtruth() == directory.path() / "groundtruth.txt");
}
