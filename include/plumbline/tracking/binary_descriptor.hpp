#pragma once
/// Binary descriptor of 256 bits, and the Hamming distance of two.                docs/math/place_recognition.md
///
///   d(a, b) = number of bits that differ, 0 to 256                                                              (1)

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace plumbline {

struct BinaryDescriptor {
  static constexpr int bits = 256;

  std::array<std::uint64_t, 4> words{};  ///< bit i is bit i % 64 of word i / 64

  bool bit(int i) const { return (words[static_cast<std::size_t>(i) / 64] >> (i % 64) & 1u) != 0; }
  bool operator==(const BinaryDescriptor&) const = default;
};

namespace detail {

/// Bits that are set in both words together. Without an instruction that counts bits, `std::popcount` is a call for
/// each word; here the two share the last steps.
inline int count_bits(std::uint64_t x, std::uint64_t y) {
#if defined(__x86_64__) && !defined(__POPCNT__)
  constexpr std::uint64_t pairs = 0x5555555555555555u, nibbles = 0x3333333333333333u, bytes = 0x0F0F0F0F0F0F0F0Fu;
  x -= x >> 1 & pairs;
  y -= y >> 1 & pairs;
  x = (x & nibbles) + (x >> 2 & nibbles) + (y & nibbles) + (y >> 2 & nibbles);  // of each nibble, at most 8
  return static_cast<int>(((x & bytes) + (x >> 4 & bytes)) * 0x0101010101010101u >> 56);
#else
  return std::popcount(x) + std::popcount(y);
#endif
}

}  // namespace detail

/// (1)
inline int hamming_distance(const BinaryDescriptor& a, const BinaryDescriptor& b) {
  return detail::count_bits(a.words[0] ^ b.words[0], a.words[1] ^ b.words[1]) +
         detail::count_bits(a.words[2] ^ b.words[2], a.words[3] ^ b.words[3]);
}

/// (1) where it is at most `limit`, else any larger number: half of the bits tell for most pairs.
inline int hamming_distance(const BinaryDescriptor& a, const BinaryDescriptor& b, int limit) {
  const int half = detail::count_bits(a.words[0] ^ b.words[0], a.words[1] ^ b.words[1]);
  if (half > limit) return half;
  return half + detail::count_bits(a.words[2] ^ b.words[2], a.words[3] ^ b.words[3]);
}

}  // namespace plumbline
