#include "plumbline/tracking/descriptor_matching.hpp"

#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

std::vector<BinaryDescriptor> random_descriptors(std::size_t n, std::uint64_t seed) {
  Random random(seed);
  std::vector<BinaryDescriptor> out(n);
  for (BinaryDescriptor& d : out) {
    for (auto& word : d.words) word = random.next();
  }
  return out;
}

BinaryDescriptor with_flipped(BinaryDescriptor d, int bits) {
  for (int i = 0; i < bits; ++i) d.words[static_cast<std::size_t>(i % 4)] ^= std::uint64_t{1} << (i / 4);
  return d;
}

std::vector<DescriptorMatch> matches(const std::vector<BinaryDescriptor>& a, const std::vector<BinaryDescriptor>& b,
                                     const DescriptorMatchOptions& options = {}) {
  std::vector<DescriptorMatch> out(a.size());
  out.resize(match_descriptors(a, b, options, out));
  return out;
}

}  // namespace

TEST_CASE("descriptor matching: a shuffled copy with noise is found, others are not") {
  const std::vector<BinaryDescriptor> first = random_descriptors(60, 1);
  std::vector<BinaryDescriptor> second = random_descriptors(40, 2);
  for (std::size_t i = 0; i < 30; ++i) second.push_back(with_flipped(first[29 - i], 20));
  const std::vector<DescriptorMatch> found = matches(first, second);
  REQUIRE(found.size() == 30);
  for (std::size_t i = 0; i < 30; ++i) {
    REQUIRE(found[i].first == i);
    REQUIRE(found[i].second == 40 + 29 - i);
    REQUIRE(found[i].distance == 20);
  }
}

TEST_CASE("descriptor matching: the ratio is asked from both sides, and can be turned off") {
  const std::vector<BinaryDescriptor> first = random_descriptors(3, 3);
  const std::vector<BinaryDescriptor> twice = {with_flipped(first[0], 20), with_flipped(first[0], 22), first[1]};
  REQUIRE(matches(first, twice).size() == 1);
  REQUIRE(matches(twice, first).size() == 1);
  DescriptorMatchOptions options;
  options.max_ratio = 1;
  REQUIRE(matches(first, twice, options).size() == 2);
  REQUIRE(matches(twice, first, options).size() == 2);
}

TEST_CASE("descriptor matching: distances up to the limit alone") {
  const std::vector<BinaryDescriptor> first = random_descriptors(1, 4);
  DescriptorMatchOptions options;
  options.max_distance = 30;
  REQUIRE(matches(first, {with_flipped(first[0], 30)}, options).size() == 1);
  REQUIRE(matches(first, {with_flipped(first[0], 31)}, options).empty());
}

TEST_CASE("descriptor matching: forbidden pairs are not compared, a full output takes no more, nothing gives nothing") {
  const std::vector<BinaryDescriptor> some = random_descriptors(20, 5);
  std::vector<DescriptorMatch> out(20);
  const std::size_t shifted =
      match_descriptors(some, some, {}, out, [](std::size_t i, std::size_t j) { return i != j; });
  REQUIRE(shifted == 0);
  REQUIRE(match_descriptors(some, some, {}, std::span(out).first(5)) == 5);
  REQUIRE(match_descriptors(some, {}, {}, out) == 0);
  REQUIRE(match_descriptors({}, some, {}, out) == 0);
}
