#include "plumbline/map/hamming_tree.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t capacity = 2000;
using Tree = HammingTree<capacity, 16>;

std::vector<BinaryDescriptor> random_descriptors(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<BinaryDescriptor> out(n);
  for (BinaryDescriptor& d : out) {
    for (auto& word : d.words) word = random.next();
  }
  return out;
}

bool has(const Tree& tree, std::uint32_t entry, const BinaryDescriptor& x) {
  const auto leaf = tree.find(x);
  return std::find(leaf.begin(), leaf.end(), entry) != leaf.end();
}

}  // namespace

TEST_CASE("hamming tree: every entry is in the leaf of its descriptor, leaves stay within their size") {
  const std::vector<BinaryDescriptor> all = random_descriptors(capacity, 1);
  const auto of = [&](std::uint32_t e) -> const BinaryDescriptor& { return all[e]; };
  const auto tree = std::make_unique<Tree>();
  for (std::uint32_t i = 0; i < capacity; ++i) REQUIRE(tree->add(i, all[i], of));
  for (std::uint32_t i = 0; i < capacity; ++i) {
    REQUIRE(has(*tree, i, all[i]));
    REQUIRE(tree->find(all[i]).size() <= 16);
  }
  REQUIRE(tree->leaves() > capacity / 16);
  REQUIRE(tree->leaves() <= Tree::max_leaves);
}

TEST_CASE("hamming tree: what was removed is gone, and leaves are used again") {
  const auto tree = std::make_unique<Tree>();
  std::vector<BinaryDescriptor> all = random_descriptors(capacity, 2);
  const auto of = [&](std::uint32_t e) -> const BinaryDescriptor& { return all[e]; };
  for (std::uint32_t i = 0; i < capacity; ++i) tree->add(i, all[i], of);
  for (std::uint64_t round = 3; round < 9; ++round) {  // each entry is replaced six times
    const std::vector<BinaryDescriptor> next = random_descriptors(capacity, round);
    for (std::uint32_t i = 0; i < capacity; ++i) {
      REQUIRE(tree->remove(i, all[i]));
      REQUIRE(!has(*tree, i, all[i]));
      REQUIRE(!tree->remove(i, all[i]));
      all[i] = next[i];
      REQUIRE(tree->add(i, all[i], of));
    }
  }
  for (std::uint32_t i = 0; i < capacity; ++i) REQUIRE(tree->remove(i, all[i]));
  REQUIRE(tree->leaves() == 1);
}

TEST_CASE("hamming tree: a full leaf of equal descriptors refuses more") {
  const std::vector<BinaryDescriptor> all(20);
  const auto of = [&](std::uint32_t e) -> const BinaryDescriptor& { return all[e]; };
  const auto tree = std::make_unique<Tree>();
  for (std::uint32_t i = 0; i < 20; ++i) REQUIRE(tree->add(i, all[i], of) == (i < 16));
  REQUIRE(!tree->remove(17, all[17]));
  REQUIRE(tree->remove(3, all[3]));
  REQUIRE(tree->add(17, all[17], of));
}

TEST_CASE("hamming tree: only the bits it is told to test count") {
  std::vector<BinaryDescriptor> all = random_descriptors(400, 10);
  const auto of = [&](std::uint32_t e) -> const BinaryDescriptor& { return all[e]; };
  const auto tree = std::make_unique<Tree>();
  tree->test_bits(1, 4);
  for (std::uint32_t i = 0; i < all.size(); ++i) tree->add(i, all[i], of);
  for (std::uint32_t i = 0; i < all.size(); ++i) {
    BinaryDescriptor other = all[i];
    for (auto& word : other.words) word ^= ~std::uint64_t{0x2222222222222222};
    REQUIRE(has(*tree, i, other));
  }
}
