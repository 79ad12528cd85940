#include "plumbline/feature/make_room.hpp"

#include <cstdint>

#include "catch.hpp"
#include "plumbline/core/fixed_vector.hpp"

using namespace plumbline;

namespace {
struct Landmark {
  std::uint32_t id;
  int misses;
  struct {
    bool valid;
  } current;
};
using Landmarks = FixedVector<Landmark, 4>;

bool has(const Landmarks& landmarks, std::uint32_t id) {
  return std::any_of(landmarks.begin(), landmarks.end(), [id](const Landmark& x) { return x.id == id; });
}
}  // namespace

TEST_CASE("make_room: a map that is not full stays as it is") {
  Landmarks landmarks;
  landmarks.push_back({1, 9, {false}});
  REQUIRE(make_room(landmarks));
  REQUIRE(landmarks.size() == 1);
}

TEST_CASE("make_room: the landmark missed most often goes, of equals the oldest, never one in sight") {
  Landmarks landmarks;
  landmarks.push_back({5, 2, {false}});
  landmarks.push_back({4, 3, {false}});
  landmarks.push_back({3, 3, {false}});
  landmarks.push_back({2, 9, {true}});
  for (std::uint32_t gone : {3u, 4u, 5u}) {
    REQUIRE(make_room(landmarks));
    REQUIRE(landmarks.size() == 3);
    REQUIRE_FALSE(has(landmarks, gone));
    landmarks.push_back({gone + 10, 0, {true}});
  }
  REQUIRE_FALSE(make_room(landmarks));
  REQUIRE(landmarks.size() == 4);
}
