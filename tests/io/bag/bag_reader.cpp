#include "plumbline/io/bag/bag_reader.hpp"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "catch.hpp"

using namespace plumbline::io::bag;

namespace {

/// A bag of topics alone.
class TopicsOnly final : public BagReader {
 public:
  explicit TopicsOnly(std::vector<Topic> topics) : each_(std::move(topics)) {}

  std::optional<MessagePlace> next() override {
    if (at_ == each_.size()) return std::nullopt;
    const std::size_t topic = topic_index(each_[at_++]);
    return MessagePlace{topic, {.offset = at_}};
  }
  Bytes read(const Place&, std::size_t at_most) override {
    return Bytes(bytes_).first(std::min(at_most, sizeof bytes_));
  }

 private:
  std::vector<Topic> each_;
  std::size_t at_ = 0;
  std::uint8_t bytes_[4] = {1, 2, 3, 4};
};

}  // namespace

TEST_CASE("bag_reader: a topic is known by name, type and serialization, in the order in which it was met") {
  const std::vector<Topic> met = {{"/a", "T", Serialization::ros1}, {"/b", "T", Serialization::ros1},
                                  {"/a", "T", Serialization::ros1}, {"/a", "U", Serialization::ros1},
                                  {"/a", "T", Serialization::cdr},  {"/b", "T", Serialization::ros1}};
  TopicsOnly bag(met);
  CHECK(bag.topics().empty());
  std::vector<std::size_t> indices;
  for (std::size_t known = 0; const auto found = bag.next(); known = bag.topics().size()) {
    CHECK(found->topic <= known);  // no place is left out
    indices.push_back(found->topic);
  }
  CHECK(indices == std::vector<std::size_t>{0, 1, 0, 2, 3, 1});
  REQUIRE(bag.topics().size() == 4);
  for (std::size_t i = 0; i < met.size(); ++i) {
    CHECK(bag.topics()[indices[i]].name == met[i].name);
    CHECK(bag.topics()[indices[i]].type == met[i].type);
    CHECK(bag.topics()[indices[i]].serialization == met[i].serialization);
  }
}

TEST_CASE("bag_reader: a message is outside of chunks and read whole, unless said otherwise") {
  TopicsOnly bag(std::vector<Topic>{{"/a", "T"}});
  const auto found = bag.next();
  REQUIRE(found);
  CHECK(found->place.container == Place::no_container);
  BagReader& reader = bag;
  CHECK(reader.read(found->place).size() == 4);
  CHECK(reader.read(found->place, 3).size() == 3);
  CHECK(reader.remark().empty());
  reader.release();
  CHECK(reader.read(found->place)[3] == 4);
  STATIC_REQUIRE_FALSE(std::is_copy_constructible_v<BagReader>);  // one file, one reader
}
