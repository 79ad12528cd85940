#include "plumbline/map/loop_candidates.hpp"

#include <algorithm>
#include <vector>

#include "catch.hpp"
#include "plumbline/map/keyframe_slots.hpp"

using namespace plumbline;

namespace {

struct Keyframe {
  std::uint32_t id = 0;
  bool is_retired = true;
};
/// Keyframes with the ids 1, 2, ... in the slots 0, 1, ...
struct Places {
  static constexpr int none = -1;
  KeyframeSlots<Keyframe, 8> all;

  explicit Places(int count) {
    for (int k = 0; k < count; ++k) {
      all[k].id = std::uint32_t(k + 1);
      all.append();
    }
  }
  int find(std::uint32_t id) const { return all.find(id); }
  int slot(int k) const { return all.slot(k); }
  const Keyframe& keyframe(int k) const { return all[k]; }
  const Keyframe& in_slot(int slot) const { return all.in_slot(slot); }
};
/// Answers with these slots, by rank, as far as they are accepted.
struct Index {
  std::vector<PlaceCandidate> ranked;
  std::size_t asked = 0;
  std::size_t query(std::span<const BinaryDescriptor> seen, std::span<PlaceCandidate> out, auto&& accept) {
    asked = seen.size();
    std::size_t n = 0;
    for (const PlaceCandidate& each : ranked)
      if (n < out.size() && accept(each.id)) out[n++] = each;
    return n;
  }
};
const std::vector<BinaryDescriptor> descriptors(5);

}  // namespace

TEST_CASE("loop_candidates: those that are accepted and look alike enough, one by one") {
  Places places(6);
  places.all[2].is_retired = false;
  Index index{{{2, 0.9f}, {0, 0.8f}, {3, 0.5f}, {1, 0.1f}}};
  LoopCandidates<Places> candidates;
  CHECK((!candidates.any() && candidates.all_taken()));
  candidates.query(index, places, 5, descriptors, 0.3f, [](const Keyframe& keyframe) { return keyframe.is_retired; });
  CHECK(index.asked == 5);
  REQUIRE(candidates.any());
  CHECK(candidates.asked(places) == 5);
  CHECK(candidates.take(places, 5) == 0);
  CHECK_FALSE(candidates.all_taken());
  CHECK(candidates.take(places, 5) == 3);
  CHECK(candidates.all_taken());  // the third one scores too low
  index.ranked = {{1, 0.2f}};
  candidates.query(index, places, 5, descriptors, 0.3f, [](const Keyframe&) { return true; });
  CHECK((!candidates.any() && candidates.all_taken()));
}

TEST_CASE("loop_candidates: keyframes may be removed while they are taken") {
  Places places(6);
  Index index{{{0, 0.9f}, {1, 0.8f}, {4, 0.7f}}};
  LoopCandidates<Places> candidates;
  candidates.query(index, places, 3, descriptors, 0.3f, [](const Keyframe&) { return true; });
  places.all.remove(0);
  CHECK(candidates.asked(places) == 2);                                      // moved up
  CHECK(candidates.take(places, candidates.asked(places)) == Places::none);  // gone
  CHECK(candidates.take(places, candidates.asked(places)) == 0);             // slot 1
  CHECK(candidates.take(places, candidates.asked(places)) == Places::none);  // later than the one that was asked for
  places.all.remove(2);
  CHECK(candidates.asked(places) == Places::none);
}
