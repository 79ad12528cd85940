#include "plumbline/map/place_index.hpp"

#include "catch.hpp"
#include "plumbline/map/hamming_place_index.hpp"

using namespace plumbline;

namespace {

/// The least that is an index: it knows no place.
struct NoPlaces {
  static constexpr std::size_t max_keyframes = 0, max_descriptors = 0;
  bool add(std::uint32_t, std::span<const BinaryDescriptor>) { return false; }
  bool remove(std::uint32_t) { return false; }
  std::size_t query(std::span<const BinaryDescriptor>, std::span<PlaceCandidate>) { return 0; }
  std::size_t query(std::span<const BinaryDescriptor>, std::span<PlaceCandidate>, auto&&) { return 0; }
  std::size_t size() const { return 0; }
  bool contains(std::uint32_t) const { return false; }
  void clear() {}
};

struct WithoutRemove : NoPlaces {
  bool remove(std::uint32_t) = delete;
};

}  // namespace

TEST_CASE("place index: what is one and what is not") {
  STATIC_REQUIRE(PlaceIndex<NoPlaces>);
  STATIC_REQUIRE(PlaceIndex<HammingPlaceIndex<10, 100>>);
  STATIC_REQUIRE(!PlaceIndex<WithoutRemove>);
  STATIC_REQUIRE(!PlaceIndex<PlaceCandidate>);
}
