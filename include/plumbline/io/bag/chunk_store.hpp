#pragma once
/// The chunks of one file, of which the two used last are in memory: gray and depth images may lie in different ones.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "plumbline/io/bag/bag_file.hpp"
#include "plumbline/io/bag/bag_reader.hpp"
#include "plumbline/io/bag/decompress.hpp"

namespace plumbline::io::bag {

class ChunkStore {
 public:
  explicit ChunkStore(BagFile& file) : file_(&file) {}

  std::uint32_t add(const Chunk& chunk) {
    chunks_.push_back(chunk);
    return static_cast<std::uint32_t>(chunks_.size() - 1);
  }
  const Chunk& chunk(std::uint32_t index) const { return chunks_[index]; }

  /// All bytes of a chunk; valid until two others were asked for. Throws Damage.
  Bytes bytes(std::uint32_t index) {
    if (latest_.index != index) {
      std::swap(latest_, other_);
      if (latest_.index != index) {
        latest_.index = Place::no_container;
        decompress(*file_, chunks_[index], latest_.bytes);
        latest_.index = index;
      }
    }
    return latest_.bytes;
  }

  /// Memory of chunks that may be read again.
  void release() {
    latest_ = {};
    other_ = {};
    outside_ = {};
  }

  /// The bytes of a message in a chunk or outside of all.
  Bytes read(const Place& place, std::size_t at_most) {
    const std::uint64_t size = std::min<std::uint64_t>(place.size, at_most);
    if (place.container == Place::no_container) {
      file_->read(place.offset, outside_, size);
      return outside_;
    }
    return bytes(place.container).subspan(static_cast<std::size_t>(place.offset), static_cast<std::size_t>(size));
  }

 private:
  struct Slot {
    std::uint32_t index = Place::no_container;
    std::vector<std::uint8_t> bytes;
  };
  BagFile* file_;
  std::vector<Chunk> chunks_;
  Slot latest_, other_;
  std::vector<std::uint8_t> outside_;
};

}  // namespace plumbline::io::bag
