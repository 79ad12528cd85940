#include "plumbline/io/bag/messages.hpp"

#include <string>

#include "bag_writer.hpp"
#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::io::bag;

namespace {

Bytes bytes_in(const std::string& text) { return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()}; }

}  // namespace

TEST_CASE("messages are read as ROS 1 and ROS 2 serialize them") {
  for (const auto s : {Serialization::ros1, Serialization::cdr}) {
    for (const bool is_big : {false, true}) {
      if (is_big && s == Serialization::ros1) continue;
      const std::string imu = test::imu_message(s, 5'000'000'123, 0.25, 9.5, is_big);
      const plumbline::ImuSample sample = read_imu_message(bytes_in(imu), s);
      REQUIRE(sample.t_ns == 5'000'000'123);
      REQUIRE(sample.gyro == plumbline::Vec<double, 3>(0.25, 0, 0));
      REQUIRE(sample.accel == plumbline::Vec<double, 3>(0, 0, 9.5));

      const std::string image = test::image_message(s, 7, 3, 2, "mono8", "abcdef", is_big);
      const ImageMessage read = read_image_message(bytes_in(image), s);
      REQUIRE(read.t_ns == 7);
      REQUIRE(read.width == 3);
      REQUIRE(read.height == 2);
      REQUIRE(read.step == 3);
      REQUIRE(read.encoding == "mono8");
      REQUIRE(std::string(read.data.begin(), read.data.end()) == "abcdef");
    }
    const std::string compressed = test::compressed_message(s, 9, "jpeg", "bytes");
    const CompressedImageMessage file = read_compressed_message(bytes_in(compressed), s);
    REQUIRE(file.t_ns == 9);
    REQUIRE(file.format == "jpeg");
    REQUIRE(file.data.size() == 5);

    const std::string info = test::camera_info_message(s, 1, 64, 48);
    const CameraInfoMessage camera = read_camera_info_message(bytes_in(info), s);
    REQUIRE(camera.width == 64);
    REQUIRE(camera.height == 48);
    REQUIRE(camera.distortion_model == "plumb_bob");
    REQUIRE(camera.D.size() == 5);
    REQUIRE(camera.D[1] == 0.125);
    REQUIRE(camera.K[4] == 17);
  }
}

TEST_CASE("a message that ends early is refused at every length") {
  for (const auto s : {Serialization::ros1, Serialization::cdr}) {
    const std::string image = test::image_message(s, 7, 3, 2, "mono8", "abcdef");
    for (std::size_t n = 0; n < image.size(); ++n)
      REQUIRE(!message_of([&] { read_image_message(bytes_in(image.substr(0, n)), s); }).empty());
    const std::string imu = test::imu_message(s, 7, 0, 0);
    for (std::size_t n = 0; n + 72 < imu.size(); ++n)  // a covariance at the end is not used
      REQUIRE(!message_of([&] { read_imu_message(bytes_in(imu.substr(0, n)), s); }).empty());
  }
}

TEST_CASE("values that cannot be are refused") {
  const auto s = Serialization::cdr;
  const std::string nan = test::imu_message(s, 7, std::nan(""), 0);
  REQUIRE(message_of([&] { read_imu_message(bytes_in(nan), s); }) == "has a value that is not finite");
  std::string other = test::imu_message(s, 7, 0, 0);
  other[1] = 3;  // a parameter list
  REQUIRE(message_of([&] { read_imu_message(bytes_in(other), s); }).find("encapsulation 3") != std::string::npos);
  std::string counts = test::camera_info_message(s, 1, 64, 48);
  counts[counts.find("plumb_bob") + 12] = '\x7f';  // the count of D
  REQUIRE(!message_of([&] { read_camera_info_message(bytes_in(counts), s); }).empty());
}

TEST_CASE("types are known by their names in ROS 1 and ROS 2") {
  REQUIRE(message_kind("sensor_msgs/Image") == MessageKind::image);
  REQUIRE(message_kind("sensor_msgs/msg/CompressedImage") == MessageKind::compressed_image);
  REQUIRE(message_kind("sensor_msgs/msg/Imu") == MessageKind::imu);
  REQUIRE(message_kind("sensor_msgs/CameraInfo") == MessageKind::camera_info);
  REQUIRE(!message_kind("std_msgs/Image"));
  REQUIRE(!message_kind("sensor_msgs/PointCloud2"));
}
