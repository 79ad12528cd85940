#include "plumbline/io/bag/bag_index.hpp"

#include <limits>

#include "bag_writer.hpp"
#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::io::bag;
using plumbline::TimeNs;

namespace {

std::vector<IndexedTopic> index_of_messages(const test::BagFormat& format,
                                            const std::vector<test::WrittenMessage>& messages) {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "bag";
  test::write_bag(file, format, messages);
  Bag bag(file);
  return index_of(bag);
}
const IndexedTopic& topic_of(const std::vector<IndexedTopic>& index, const std::string& name) {
  for (const IndexedTopic& each : index)
    if (each.topic.name == name) return each;
  throw std::runtime_error("no topic " + name);
}

}  // namespace

TEST_CASE("bag_index: images by time and place, samples, and the calibration, in every format") {
  for (const test::BagFormat& format : test::bag_formats) {
    CAPTURE(format.name, format.compression);
    const TemporaryDirectory directory;
    const auto file = directory.path() / "bag";
    test::write_bag(file, format, test::robot_messages(format.serialization));
    Bag bag(file);
    const auto index = index_of(bag);
    REQUIRE(index.size() == 5);
    const IndexedTopic& gray = topic_of(index, "/cam/image_raw");
    REQUIRE(gray.images.size() == std::size_t(test::frames));
    CHECK((gray.kind == MessageKind::image && !gray.is_depth && gray.messages == gray.images.size()));
    for (int i = 0; i < test::frames; ++i) {
      CHECK(gray.images[std::size_t(i)].t_ns == test::frame_ns(i));
      const ImageMessage image = read_image_message(bag.read(gray.images[std::size_t(i)].place), format.serialization);
      CHECK(std::string(image.data.begin(), image.data.end()) == test::gray_pixels(i));
    }
    CHECK(topic_of(index, "/cam/depth").is_depth);
    const IndexedTopic& imu = topic_of(index, "/imu");
    REQUIRE(imu.imu.size() == std::size_t(5 * test::frames));
    CHECK((imu.imu[7].t_ns == test::frame_ns(1) + 20'000'000 && imu.imu[7].gyro.x() == 0.01 * 7));
    CHECK(topic_of(index, "/cam/camera_info").camera_info->width == std::uint32_t(test::width));
    CHECK(!topic_of(index, "/chatter").kind);
    CHECK(topic_of(index, "/chatter").messages == std::size_t(test::frames));
    for (const IndexedTopic& each : index) CHECK((each.skipped == 0 && each.first_skipped.empty()));
  }
}

TEST_CASE("bag_index: messages are put in order of time, and the first of those with the same time is kept") {
  const auto s = Serialization::cdr;
  std::vector<test::WrittenMessage> messages;
  const TimeNs times[] = {30, 10, 20, 10, 40, 10};
  for (int i = 0; i < 6; ++i) messages.push_back({times[i], "/imu", "Imu", test::imu_message(s, times[i], i, 9.81)});
  messages.push_back({20, "/image", "Image", test::image_message(s, 20, 3, 2, "mono8", "abcdef")});
  messages.push_back({10, "/image", "Image", test::image_message(s, 10, 3, 2, "mono8", "ghijkl")});
  const auto index = index_of_messages({"mcap", "none", s}, messages);
  const IndexedTopic& imu = topic_of(index, "/imu");
  REQUIRE(imu.imu.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(imu.imu[i].t_ns == TimeNs(10 * (i + 1)));
  CHECK(imu.imu[0].gyro.x() == 1);
  CHECK((imu.messages == 6 && imu.skipped == 2));
  CHECK(imu.first_skipped == "the time stamp is that of another message");
  const IndexedTopic& image = topic_of(index, "/image");
  REQUIRE(image.images.size() == 2);
  CHECK((image.images[0].t_ns == 10 && image.images[1].t_ns == 20 && image.skipped == 0));
}

TEST_CASE("bag_index: a message that cannot be read is skipped, counted and said, and others are taken") {
  const auto s = Serialization::ros1;
  const std::string whole = test::imu_message(s, 2, 0.5, 9.81);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto index = index_of_messages({"ros1", "none", s}, {{1, "/imu", "Imu", test::imu_message(s, 1, 0, 9.81)},
                                                             {2, "/imu", "Imu", whole.substr(0, 40)},
                                                             {3, "/imu", "Imu", test::imu_message(s, 3, nan, 9.81)},
                                                             {4, "/imu", "Imu", test::imu_message(s, 4, 0, 9.81)}});
  const IndexedTopic& imu = topic_of(index, "/imu");
  CHECK((imu.messages == 4 && imu.skipped == 2 && imu.imu.size() == 2));
  CHECK(imu.first_skipped.starts_with("message 2 "));
}

TEST_CASE("bag_index: the first calibration counts, and that of a camera without one does not") {
  const auto s = Serialization::cdr;
  std::string none = test::camera_info_message(s, 1, 64, 48);
  const double focal = 16;
  std::string bytes(reinterpret_cast<const char*>(&focal), sizeof focal);
  none.replace(none.find(bytes), sizeof focal, sizeof focal, '\0');
  const auto index =
      index_of_messages({"mcap", "none", s}, {{1, "/info", "CameraInfo", none},
                                              {2, "/info", "CameraInfo", test::camera_info_message(s, 2, 32, 24)},
                                              {3, "/info", "CameraInfo", test::camera_info_message(s, 3, 16, 12)}});
  REQUIRE(topic_of(index, "/info").camera_info);
  CHECK(topic_of(index, "/info").camera_info->width == 32);
}

TEST_CASE("bag_index: compressed images are depth by their format") {
  const auto s = Serialization::ros1;
  const auto is_depth = [&](const std::string& text) {
    const auto index = index_of_messages(
        {"ros1", "none", s}, {{5, "/image", "CompressedImage", test::compressed_message(s, 5, text, "file")}});
    REQUIRE(topic_of(index, "/image").images.size() == 1);
    return topic_of(index, "/image").is_depth;
  };
  CHECK_FALSE(is_depth("jpeg"));
  CHECK_FALSE(is_depth("mono8; jpeg compressed "));
  CHECK(is_depth("16UC1; png compressed "));
  CHECK(is_depth("32FC1; compressedDepth"));
}
