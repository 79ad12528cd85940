#include "plumbline_ros2/conversions.hpp"

#include <cstring>
#include <limits>
#include <memory>
#include <string>

#include "catch.hpp"
#include "message_like.hpp"
#include "plumbline/io/bag/camera_info.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::ros2;

TEST_CASE("stamps and times") {
  for (const plumbline::TimeNs t_ns : {0LL, 1'700'000'000'123'456'789LL, -1LL, -2'000'000'000LL, -1'500'000'000LL}) {
    message_like::Time stamp;
    set_stamp(t_ns, stamp);
    REQUIRE(stamp.nanosec < 1'000'000'000);
    REQUIRE(time_of(stamp) == t_ns);
  }
  message_like::Time before;
  set_stamp(-1, before);
  REQUIRE(before.sec == -1);
  REQUIRE(before.nanosec == 999'999'999);
  REQUIRE(message_of([] {
            time_of(message_like::Time{1, 1'000'000'000});
          }).find("1e9 nanoseconds") != std::string::npos);
}

TEST_CASE("an IMU message is a sample, unless a value is not finite") {
  message_like::Imu message;
  message.header.stamp = {5, 123};
  message.angular_velocity = {0.1, 0.2, 0.3};
  message.linear_acceleration = {1, 2, 9.5};
  const plumbline::ImuSample sample = imu_sample_of(message);
  REQUIRE(sample.t_ns == 5'000'000'123);
  REQUIRE(sample.gyro == plumbline::Vec<double, 3>(0.1, 0.2, 0.3));
  REQUIRE(sample.accel == plumbline::Vec<double, 3>(1, 2, 9.5));
  message.linear_acceleration.y = std::numeric_limits<double>::quiet_NaN();
  REQUIRE(message_of([&] { imu_sample_of(message); }).find("not finite") != std::string::npos);
}

TEST_CASE("an image message is kept, and becomes gray of the size of the calibration") {
  auto message = std::make_shared<message_like::Image>(message_like::gray_image(7, 9, 3, 2, 50));
  message->encoding = "rgb8";
  message->step = 10;  // a byte between the rows
  message->data.assign(20, 0);
  message->data[10] = 255;  // red, in the second row
  const std::weak_ptr<message_like::Image> watched = message;
  HeldImage held = held_image_of<message_like::Image>(std::move(message));
  REQUIRE(!watched.expired());
  REQUIRE(held.image.t_ns == 7'000'000'009);
  const cv::Mat gray = gray_of(held, 3, 2);
  REQUIRE(gray.type() == CV_8UC1);
  REQUIRE(gray.at<std::uint8_t>(1, 0) == 76);
  REQUIRE(gray.at<std::uint8_t>(0, 0) == 0);
  REQUIRE(message_of([&] { gray_of(held, 4, 2); }).find("the calibration has 4 x 2") != std::string::npos);
  held = {};
  REQUIRE(watched.expired());
}

TEST_CASE("depth in millimeters and in meters is the same, in raw units") {
  const auto depth_image = [](const std::string& encoding, const void* pixels, std::size_t size) {
    auto out = std::make_shared<message_like::Image>();
    out->width = 2;
    out->height = 1;
    out->encoding = encoding;
    out->step = static_cast<std::uint32_t>(size);
    out->data.resize(size);
    std::memcpy(out->data.data(), pixels, size);
    return held_image_of<message_like::Image>(out);
  };
  const std::uint16_t millimeters[2] = {1500, 0};
  const float meters[2] = {1.5F, std::numeric_limits<float>::quiet_NaN()};
  const HeldImage of_integers = depth_image("16UC1", millimeters, sizeof millimeters);
  const HeldImage of_floats = depth_image("32FC1", meters, sizeof meters);
  for (const HeldImage& held : {of_integers, of_floats}) {
    const cv::Mat depth = depth_of(held, 2, 1, 1000);
    REQUIRE(depth.type() == CV_16UC1);
    REQUIRE(depth.at<std::uint16_t>(0, 0) == 1500);
    REQUIRE(depth.at<std::uint16_t>(0, 1) == 0);
  }
  REQUIRE(depth_of(of_floats, 2, 1, 5000).at<std::uint16_t>(0, 0) == 7500);
}

TEST_CASE("camera_info is a calibration") {
  message_like::CameraInfo info;
  info.width = 640;
  info.height = 480;
  info.distortion_model = "plumb_bob";
  info.d = {0.1, -0.2, 0.001, 0.002, 0};
  info.k = {500, 0, 320, 0, 510, 240, 0, 0, 1};
  const plumbline::io::Calibration calibration =
      plumbline::io::bag::calibration_of("camera_info", camera_info_of(info));
  REQUIRE(calibration.camera.width == 640);
  REQUIRE(calibration.camera.intrinsics == std::vector<double>{500, 510, 320, 240});
  REQUIRE(calibration.camera.distortion == "radtan");
  REQUIRE(calibration.camera.distortion_coefficients[1] == -0.2);
  info.k = {};
  REQUIRE(!message_of([&] { plumbline::io::bag::calibration_of("camera_info", camera_info_of(info)); }).empty());
}
