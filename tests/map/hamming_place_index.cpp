#include "plumbline/map/hamming_place_index.hpp"

#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

using Index = HammingPlaceIndex<40, 50>;
using Descriptors = std::vector<BinaryDescriptor>;

Descriptors random_place(std::uint64_t seed, std::size_t n = 50) {
  Random random(seed);
  Descriptors out(n);
  for (BinaryDescriptor& d : out) {
    for (auto& word : d.words) word = random.next();
  }
  return out;
}

/// The place seen again: one bit of 16 is turned, and only the first `seen` descriptors are the same.
Descriptors seen_again(Descriptors place, std::size_t seen, std::uint64_t seed) {
  Random random(seed);
  const Descriptors other = random_place(seed + 1000, place.size());
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (i >= seen) place[i] = other[i];
    for (auto& word : place[i].words) word ^= random.next() & random.next() & random.next() & random.next();
  }
  return place;
}

std::vector<PlaceCandidate> candidates(Index& index, const Descriptors& seen, std::size_t most = 10) {
  std::vector<PlaceCandidate> out(most);
  out.resize(index.query(seen, out));
  return out;
}

std::unique_ptr<Index> with_places(std::uint32_t n) {
  auto index = std::make_unique<Index>();
  for (std::uint32_t i = 0; i < n; ++i) REQUIRE(index->add(100 + i, random_place(i)));
  return index;
}

}  // namespace

TEST_CASE("hamming place index: a place seen again is the best candidate, scores fall with what is shared") {
  const auto index = with_places(40);
  for (std::uint32_t i = 0; i < 40; i += 3) {
    float last = 1;
    for (const std::size_t shared : {50u, 25u, 12u}) {
      const std::vector<PlaceCandidate> found = candidates(*index, seen_again(random_place(i), shared, i));
      REQUIRE(!found.empty());
      REQUIRE(found[0].id == 100 + i);
      REQUIRE(found[0].score > 0);
      REQUIRE(found[0].score < last);
      last = found[0].score;
    }
  }
  const std::vector<PlaceCandidate> same = candidates(*index, random_place(7));
  REQUIRE(same[0].score == Approx(std::pow(std::log(41.0) / std::log(50.0), 2)));  // (12)
}

TEST_CASE("hamming place index: nothing is found in an empty index, with nothing seen, or of an unknown place") {
  const auto index = with_places(20);
  REQUIRE(candidates(*index, {}).empty());
  REQUIRE(candidates(*index, random_place(999)).empty());
  REQUIRE(candidates(*index, random_place(3), 0).empty());
  index->clear();
  REQUIRE(index->size() == 0);
  REQUIRE(candidates(*index, random_place(3)).empty());
}

TEST_CASE("hamming place index: candidates are sorted, at most as many as asked for, and only accepted ones") {
  const auto index = std::make_unique<Index>();
  for (std::uint32_t i = 0; i < 20; ++i) index->add(i, seen_again(random_place(1), 10 + 2 * i, i));
  const std::vector<PlaceCandidate> all = candidates(*index, random_place(1), 20),
                                    three = candidates(*index, random_place(1), 3);
  REQUIRE(all.size() == 20);
  REQUIRE(three.size() == 3);
  for (std::size_t i = 1; i < all.size(); ++i) REQUIRE(all[i].score <= all[i - 1].score);
  for (std::size_t i = 0; i < 3; ++i) REQUIRE(three[i].id == all[i].id);
  std::array<PlaceCandidate, 20> out;
  const std::size_t n = index->query(random_place(1), out, [](std::uint32_t id) { return id % 2 == 0; });
  REQUIRE(n == 10);
  for (std::size_t i = 0; i < n; ++i) REQUIRE(out[i].id % 2 == 0);
}

TEST_CASE("hamming place index: removed keyframes are not found, their room is used again") {
  const auto index = with_places(40);
  REQUIRE(!index->add(7, random_place(7)));  // full
  REQUIRE(!index->remove(7));
  for (std::uint32_t i = 0; i < 400; ++i) {  // each keyframe is replaced ten times
    REQUIRE(index->remove(100 + i));
    REQUIRE(!index->contains(100 + i));
    REQUIRE(candidates(*index, random_place(i)).empty());
    REQUIRE(index->add(140 + i, random_place(40 + i)));
    REQUIRE(!index->add(140 + i, random_place(3)));  // that id is there
    REQUIRE(index->size() == 40);
  }
  for (std::uint32_t i = 400; i < 440; ++i) {
    const std::vector<PlaceCandidate> found = candidates(*index, random_place(i));
    REQUIRE(found.size() == 1);
    REQUIRE(found[0].id == 100 + i);
    REQUIRE(found[0].score > 0.8f);
  }
}

TEST_CASE("hamming place index: descriptors beyond the capacity are left out, the others are given back") {
  const auto index = std::make_unique<Index>();
  const Descriptors many = random_place(5, 80);
  REQUIRE(index->add(1, many));
  REQUIRE(index->descriptors(1).size() == 50);
  for (std::size_t i = 0; i < 50; ++i) REQUIRE(index->descriptors(1)[i] == many[i]);
  REQUIRE(index->descriptors(2).empty());
  REQUIRE(index->add(2, {}));  // a keyframe without descriptors is never found
  REQUIRE(candidates(*index, many).size() == 1);
}

TEST_CASE("hamming place index: a descriptor of many keyframes counts less") {
  const auto index = std::make_unique<Index>();
  const Descriptors common = random_place(50, 10), own = random_place(51, 10);
  for (std::uint32_t i = 0; i < 30; ++i) {
    Descriptors seen = random_place(60 + i, 20);
    seen.insert(seen.end(), common.begin(), common.end());
    index->add(i, seen);
  }
  index->add(30, own);
  Descriptors query = own;
  query.insert(query.end(), common.begin(), common.end());
  const std::vector<PlaceCandidate> found = candidates(*index, query, 31);
  REQUIRE(found[0].id == 30);
  REQUIRE((found.size() == 1 || found[1].score < 0.05f * found[0].score));
}

TEST_CASE("hamming place index: the same calls give the same bits") {
  const auto a = with_places(30), b = with_places(30);
  for (std::uint32_t i = 0; i < 30; ++i) {
    const Descriptors seen = seen_again(random_place(i), 20, i);
    const std::vector<PlaceCandidate> x = candidates(*a, seen), y = candidates(*b, seen);
    REQUIRE(x.size() == y.size());
    for (std::size_t k = 0; k < x.size(); ++k) REQUIRE((x[k].id == y[k].id && x[k].score == y[k].score));
  }
}
