// The place index does not allocate: keyframes come and go, and are asked for.
#include "allocation_counter.hpp"

#include <array>
#include <memory>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/map/hamming_place_index.hpp"

using namespace plumbline;

TEST_CASE("no heap: add, query and remove keyframes") {
  constexpr std::size_t n = 100;
  const auto index = std::make_unique<HammingPlaceIndex<30, n>>();
  std::array<BinaryDescriptor, n> seen;
  std::array<PlaceCandidate, 5> out;
  std::size_t found = 0;
  const long allocations = test::allocations_of([&] {
    Random random(1);
    for (std::uint32_t id = 0; id < 200; ++id) {
      for (BinaryDescriptor& d : seen) {
        for (auto& word : d.words) word = random.next();
      }
      if (id >= 30) index->remove(id - 30);
      index->add(id, seen);
      found += index->query(seen, out);
    }
    index->clear();
  });
  REQUIRE(allocations == 0);
  REQUIRE(found == 200);
}
