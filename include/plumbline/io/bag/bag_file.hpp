#pragma once
/// A file read at any place, through a window of 64 KiB: of 50 GB no more is in memory.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <utility>
#include <vector>

#include "plumbline/io/bag/byte_reader.hpp"
#include "plumbline/io/bag/damage.hpp"
#include "plumbline/io/error.hpp"

namespace plumbline::io::bag {

class BagFile {
 public:
  /// Throws ReadError.
  explicit BagFile(std::filesystem::path file) : file_(std::move(file)) {
    if (!std::filesystem::exists(file_)) throw ReadError(file_, 0, "no such file");
    if (!std::filesystem::is_regular_file(file_)) throw ReadError(file_, 0, "not a regular file");
    size_ = std::filesystem::file_size(file_);
    stream_.open(file_, std::ios::binary);
    if (!stream_) throw ReadError(file_, 0, "cannot be opened");
  }

  const std::filesystem::path& path() const { return file_; }
  std::uint64_t size() const { return size_; }
  std::uint64_t left_from(std::uint64_t offset) const { return offset < size_ ? size_ - offset : 0; }

  /// So many bytes; throws Damage at the end of the file.
  void read(std::uint64_t offset, std::uint8_t* to, std::size_t count) {
    if (count > left_from(offset)) throw Damage(size_, "the file ends in a record that begins before");
    while (count > 0) {
      if (offset < begin_ || offset >= begin_ + window_.size()) fill(offset);
      const std::size_t from = static_cast<std::size_t>(offset - begin_);
      const std::size_t part = std::min(count, window_.size() - from);
      std::memcpy(to, window_.data() + from, part);
      offset += part;
      to += part;
      count -= part;
    }
  }
  /// The same into `to`, which becomes so long. Its length is checked before.
  void read(std::uint64_t offset, std::vector<std::uint8_t>& to, std::uint64_t count) {
    if (count > left_from(offset)) throw Damage(size_, "the file ends in a record that begins before");
    to.resize(static_cast<std::size_t>(count));
    read(offset, to.data(), to.size());
  }
  template <class Number>
  Number number(std::uint64_t offset) {
    std::uint8_t bytes[sizeof(Number)];
    read(offset, bytes, sizeof bytes);
    return ByteReader(bytes).number<Number>();
  }

 private:
  void fill(std::uint64_t offset) {
    constexpr std::uint64_t window = 1 << 16;
    window_.resize(static_cast<std::size_t>(std::min(window, size_ - offset)));
    begin_ = offset;
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(offset));
    stream_.read(reinterpret_cast<char*>(window_.data()), static_cast<std::streamsize>(window_.size()));
    if (stream_.gcount() == static_cast<std::streamsize>(window_.size())) return;
    window_.clear();
    begin_ = 0;
    throw Damage(offset, "the file cannot be read");
  }

  std::filesystem::path file_;
  std::ifstream stream_;
  std::uint64_t size_ = 0, begin_ = 0;
  std::vector<std::uint8_t> window_;
};

}  // namespace plumbline::io::bag
