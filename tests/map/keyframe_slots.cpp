#include "plumbline/map/keyframe_slots.hpp"

#include <vector>

#include "catch.hpp"

using namespace plumbline;

namespace {

struct Keyframe {
  std::uint32_t id = 0;
};
using Slots = KeyframeSlots<Keyframe, 4>;

void append(Slots& slots, std::uint32_t id) {
  slots[slots.size()].id = id;
  slots.append();
}
std::vector<std::uint32_t> ids(const Slots& slots) {
  std::vector<std::uint32_t> out;
  for (int k = 0; k < slots.size(); ++k) out.push_back(slots[k].id);
  return out;
}

}  // namespace

TEST_CASE("keyframe_slots: a removal closes the gap in the order, and no keyframe leaves its slot") {
  Slots slots;
  for (const std::uint32_t id : {3u, 5u, 6u, 9u}) append(slots, id);
  CHECK(slots.full());
  std::vector<int> slot_of;
  for (int k = 0; k < 4; ++k) slot_of.push_back(slots.slot(k));
  slots.remove(1);
  CHECK((ids(slots) == std::vector<std::uint32_t>{3, 6, 9} && !slots.full()));
  CHECK((slots.slot(0) == slot_of[0] && slots.slot(1) == slot_of[2] && slots.slot(2) == slot_of[3]));
  CHECK(slots.in_slot(slot_of[3]).id == 9);
  append(slots, 12);  // takes the slot that is free
  CHECK(slots.slot(3) == slot_of[1]);
  CHECK(ids(slots) == std::vector<std::uint32_t>{3, 6, 9, 12});
}

TEST_CASE("keyframe_slots: at any time the slots are those that there are, each once") {
  Slots slots;
  for (std::uint32_t id = 1; id <= 40; ++id) {
    if (slots.full()) slots.remove(int(id * 7 % 4));
    append(slots, id);
    std::vector<bool> taken(4);
    for (int k = 0; k < 4; ++k) taken[std::size_t(slots.slot(k))] = true;
    REQUIRE(taken == std::vector<bool>(4, true));
    for (int k = 1; k < slots.size(); ++k) REQUIRE(slots[k - 1].id < slots[k].id);
  }
}

TEST_CASE("keyframe_slots: a keyframe is found by its id, others are not") {
  Slots slots;
  CHECK(slots.find(0) == Slots::none);
  for (const std::uint32_t id : {3u, 5u, 9u}) append(slots, id);
  CHECK((slots.find(3) == 0 && slots.find(5) == 1 && slots.find(9) == 2));
  for (const std::uint32_t id : {0u, 4u, 6u, 10u}) CHECK(slots.find(id) == Slots::none);
  slots.remove(2);
  CHECK(slots.find(9) == Slots::none);
  slots.clear();
  CHECK((slots.size() == 0 && slots.find(3) == Slots::none));
}
