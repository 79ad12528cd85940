#include "plumbline/tracking/binary_descriptor.hpp"

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

BinaryDescriptor random_descriptor(Random& random) {
  BinaryDescriptor out;
  for (auto& word : out.words) word = random.next();
  return out;
}

}  // namespace

TEST_CASE("binary descriptor: the distance is the number of bits that differ") {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const BinaryDescriptor a = random_descriptor(random);
    BinaryDescriptor b = random_descriptor(random);
    if (k % 2 == 0) {
      for (std::size_t i = 0; i < 4; ++i) b.words[i] = a.words[i] ^ (random.next() & random.next() & random.next());
    }
    int expected = 0;
    for (int i = 0; i < BinaryDescriptor::bits; ++i) expected += a.bit(i) != b.bit(i);
    REQUIRE(hamming_distance(a, b) == expected);
    REQUIRE(hamming_distance(b, a) == expected);
    REQUIRE(hamming_distance(a, b, expected) == expected);
    REQUIRE(hamming_distance(a, b, expected - 1) > expected - 1);
  }
}

TEST_CASE("binary descriptor: none and all of the bits differ") {
  Random random(2);
  const BinaryDescriptor a = random_descriptor(random);
  BinaryDescriptor inverse = a;
  for (auto& word : inverse.words) word = ~word;
  REQUIRE(hamming_distance(a, a) == 0);
  REQUIRE(hamming_distance(a, inverse) == BinaryDescriptor::bits);
  REQUIRE(a == a);
  REQUIRE(!(a == inverse));
}

TEST_CASE("binary descriptor: bit i is bit i % 64 of word i / 64") {
  for (int i = 0; i < BinaryDescriptor::bits; ++i) {
    BinaryDescriptor one;
    one.words[static_cast<std::size_t>(i / 64)] = std::uint64_t{1} << (i % 64);
    REQUIRE(one.bit(i));
    REQUIRE(!one.bit((i + 1) % BinaryDescriptor::bits));
    REQUIRE(hamming_distance(one, BinaryDescriptor{}) == 1);
  }
}
