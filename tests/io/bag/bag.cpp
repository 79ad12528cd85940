#include "plumbline/io/bag/bag.hpp"

#include <string>
#include <vector>

#include "bag_writer.hpp"
#include "catch.hpp"
#include "temporary_directory.hpp"

using namespace plumbline::io::bag;

namespace {

std::vector<std::string> all_messages(Bag& bag) {
  std::vector<std::string> out;
  while (const auto found = bag.next()) {
    const Bytes bytes = bag.read(found->place);
    out.push_back(bag.topics()[found->topic].name + " " + std::string(bytes.begin(), bytes.end()));
  }
  return out;
}
std::vector<std::string> expected(const std::vector<test::WrittenMessage>& messages) {
  std::vector<std::string> out;
  for (const auto& message : messages) out.push_back(message.topic + " " + message.bytes);
  return out;
}

}  // namespace

TEST_CASE("all messages of a bag are read in order, and again by place") {
  const TemporaryDirectory directory;
  for (const test::BagFormat& format : test::bag_formats) {
    CAPTURE(format.name, format.compression);
    const auto messages = test::robot_messages(format.serialization);
    const auto file = directory.path() / "robot";
    test::write_bag(file, format, messages);
    REQUIRE(is_bag(file));
    Bag bag(file);
    std::vector<MessagePlace> places;
    while (const auto found = bag.next()) places.push_back(*found);
    REQUIRE(bag.notes().empty());
    REQUIRE(places.size() == messages.size());
    for (std::size_t k = 0; k < places.size(); ++k) {
      const std::size_t i = k * 37 % places.size();  // in another order
      const Bytes bytes = bag.read(places[i].place);
      REQUIRE(std::string(bytes.begin(), bytes.end()) == messages[i].bytes);
      REQUIRE(bag.topics()[places[i].topic].name == messages[i].topic);
      REQUIRE(bag.read(places[i].place, 3).size() == 3);
    }
  }
}

TEST_CASE("a bag that is cut off is read up to there, and the byte is named") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "cut";
  for (const test::BagFormat& format : test::bag_formats) {
    CAPTURE(format.name, format.compression);
    const auto messages = test::robot_messages(format.serialization);
    test::write_bag(file, format, messages);
    const std::string bytes = test::bytes_of(file);
    const std::size_t size = bytes.size() * 2 / 3;
    test::write_bytes(file, bytes.substr(0, size));
    std::vector<std::string> read;
    std::string note;
    try {
      Bag bag(file);
      read = all_messages(bag);
      REQUIRE(bag.notes().size() == 1);
      note = bag.notes().front();
    } catch (const std::runtime_error& error) {  // a database may not be opened, or a page be missing
      REQUIRE(format.name == "sqlite");
      continue;
    }
    const auto all = expected(messages);
    REQUIRE(read.size() < all.size());
    if (format.name == "sqlite") continue;
    REQUIRE(read.size() > 20);
    REQUIRE(std::equal(read.begin(), read.end(), all.begin()));
    const std::string end = std::to_string(size);
    REQUIRE(note.find("damaged at byte " + end + " of " + end + " and read up to there") != note.npos);
  }
}

TEST_CASE("a damaged chunk ends the bag at its byte") {
  const TemporaryDirectory directory;
  const auto file = directory.path() / "damaged";
  for (const test::BagFormat& format : test::bag_formats) {
    if (format.name != "mcap" && format.compression != "bz2") continue;  // the others have no check sum
    CAPTURE(format.name, format.compression);
    test::write_bag(file, format, test::robot_messages(format.serialization));
    std::string bytes = test::bytes_of(file);
    const std::size_t middle = bytes.size() / 2;
    bytes[middle] = static_cast<char>(bytes[middle] ^ 0x10);
    test::write_bytes(file, bytes);
    Bag bag(file);
    const std::size_t read = all_messages(bag).size();
    REQUIRE(read % test::messages_of_chunk == 0);
    REQUIRE(read > 0);
    REQUIRE(bag.notes().size() == 1);
    const std::string& note = bag.notes().front();
    const std::size_t at = note.find("at byte ");
    REQUIRE(at != note.npos);
    REQUIRE(std::stoul(note.substr(at + 8)) <= middle);
    REQUIRE(note.find("a chunk is damaged") != note.npos);
  }
}

TEST_CASE("a folder of ROS 2 is read file by file, in the order of its metadata") {
  const TemporaryDirectory directory;
  const auto messages = test::robot_messages(Serialization::cdr);
  const std::vector<test::WrittenMessage> first(messages.begin(), messages.begin() + 40);
  const std::vector<test::WrittenMessage> second(messages.begin() + 40, messages.end());
  test::write_bag(directory.path() / "b.mcap", {"mcap", "zstd", Serialization::cdr}, first);
  test::write_bag(directory.path() / "a.db3", {"sqlite", "", Serialization::cdr}, second);
  directory.write("metadata.yaml", "rosbag2_bagfile_information:\n  relative_file_paths:\n    - b.mcap\n    - a.db3\n");
  REQUIRE(is_bag(directory.path()));
  Bag bag(directory.path());
  REQUIRE(all_messages(bag) == expected(messages));
  REQUIRE(bag.topics().size() == 5);

  std::filesystem::remove(directory.path() / "metadata.yaml");
  Bag by_name(directory.path());
  REQUIRE(all_messages(by_name).front() == expected(second).front());
}

TEST_CASE("what is no bag is named") {
  const TemporaryDirectory directory;
  const auto message = [&](const std::string& text) {
    const auto file = directory.write("file", text);
    return message_of([&] { Bag bag(file); });
  };
  const auto file = directory.path() / "file";
  REQUIRE(reports(message(""), file, 0, "the file is empty"));
  REQUIRE(reports(message("hello"), file, 0, "not a bag: neither ROS 1"));
  REQUIRE(reports(message("#ROSBAG V1.2\n"), file, 0, "another version than 2.0"));
  REQUIRE(reports(message("\x28\xB5\x2F\xFD rest"), file, 0, "compressed as a whole"));
  REQUIRE(reports(message(std::string(sqlite_magic) + "rest"), file, 0, "not a bag of ROS 2, or damaged"));
  REQUIRE(reports(message_of([] { Bag bag("/nowhere.bag"); }), "/nowhere.bag", 0, "no such file"));
  REQUIRE(!is_bag("/nowhere.bag"));
  directory.write("folder/rgb.txt", "");
  REQUIRE(!is_bag(directory.path() / "folder"));
}
