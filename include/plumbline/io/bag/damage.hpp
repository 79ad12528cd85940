#pragma once
/// Where the bytes of a bag stop to make sense, and why: what comes before is used.

#include <cstdint>
#include <stdexcept>
#include <string>

namespace plumbline::io::bag {

class Damage : public std::runtime_error {
 public:
  static constexpr std::uint64_t no_offset = ~std::uint64_t{0};
  /// `offset_bytes` counts from the begin of the file; `no_offset` where a database does not tell it.
  Damage(std::uint64_t offset_bytes, const std::string& what) : std::runtime_error(what), offset_(offset_bytes) {}
  std::uint64_t offset_bytes() const { return offset_; }

 private:
  std::uint64_t offset_;
};

}  // namespace plumbline::io::bag
