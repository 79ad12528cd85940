#pragma once
/// A bag as a stream of messages, each of which can be read again by its place.

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "plumbline/io/bag/byte_reader.hpp"
#include "plumbline/io/bag/damage.hpp"

namespace plumbline::io::bag {

struct Topic {
  std::string name, type;
  Serialization serialization = Serialization::ros1;
};

/// Where a message is. `container` is the chunk of a file, `no_container` outside of all.
struct Place {
  static constexpr std::uint32_t no_container = std::numeric_limits<std::uint32_t>::max();
  std::uint32_t file = 0, container = no_container;
  std::uint64_t offset = 0, size = 0;
};

struct MessagePlace {
  std::size_t topic = 0;  ///< index of `BagReader::topics()`
  Place place;
};

class BagReader {
 public:
  BagReader() = default;
  BagReader(const BagReader&) = delete;
  BagReader& operator=(const BagReader&) = delete;
  virtual ~BagReader() = default;

  /// Those met up to now.
  const std::vector<Topic>& topics() const { return topics_; }
  /// The next message in the order of the file; none at the end. Throws Damage where the bag is damaged.
  virtual std::optional<MessagePlace> next() = 0;
  /// The bytes of a message, at most so many; valid until the next call of any function. Throws Damage.
  virtual Bytes read(const Place& place, std::size_t at_most = std::numeric_limits<std::size_t>::max()) = 0;
  /// Gives up memory until the next call.
  virtual void release() {}
  /// What is odd of the bag as a whole, e.g. that it was never closed; empty of most.
  virtual std::string remark() const { return {}; }

 protected:
  std::size_t topic_index(const Topic& topic) {
    for (std::size_t i = 0; i < topics_.size(); ++i)
      if (topics_[i].name == topic.name && topics_[i].type == topic.type &&
          topics_[i].serialization == topic.serialization)
        return i;
    topics_.push_back(topic);
    return topics_.size() - 1;
  }

  std::vector<Topic> topics_;
};

}  // namespace plumbline::io::bag
