#include "plumbline/core/ring_buffer.hpp"

#include <deque>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

TEST_CASE("ring_buffer: keeps the last items, oldest first") {
  RingBuffer<int, 3> buffer;
  CHECK(buffer.empty());
  for (int i = 1; i <= 5; ++i) buffer.push_back(i);
  CHECK(buffer.full());
  CHECK(buffer[0] == 3);
  CHECK(buffer[1] == 4);
  CHECK(buffer[2] == 5);
  CHECK(buffer.front() == 3);
  CHECK(buffer.back() == 5);
  buffer.pop_front();
  CHECK(buffer.size() == 2);
  CHECK(buffer.front() == 4);
  buffer.clear();
  CHECK(buffer.empty());
  buffer.push_back(9);
  CHECK(buffer.front() == 9);
  CHECK(buffer.back() == 9);
}

TEST_CASE("ring_buffer: behaves as a deque cut to its capacity") {
  Random random(1);
  RingBuffer<int, 7> buffer;
  std::deque<int> reference;
  for (int i = 0; i < 5000; ++i) {
    const auto what = random.below(4);
    const std::size_t place = random.below(reference.size() + 1);
    if (what == 0 && (place > 0 || reference.size() < 7)) {
      const std::size_t at = buffer.insert(place, i);
      reference.insert(reference.begin() + std::ptrdiff_t(place), i);
      if (reference.size() > 7) reference.pop_front();
      REQUIRE(buffer[at] == i);
    } else if (what < 3 || reference.empty()) {
      buffer.push_back(i);
      reference.push_back(i);
      if (reference.size() > 7) reference.pop_front();
    } else {
      buffer.pop_front();
      reference.pop_front();
    }
    REQUIRE(buffer.size() == reference.size());
    for (std::size_t k = 0; k < reference.size(); ++k) REQUIRE(buffer[k] == reference[k]);
  }
}

TEST_CASE("ring_buffer: of one item") {
  RingBuffer<int, 1> buffer;
  buffer.push_back(1);
  buffer.push_back(2);
  CHECK(buffer.size() == 1);
  CHECK(buffer.front() == 2);
}
