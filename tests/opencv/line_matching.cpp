#include "plumbline/opencv/line_matching.hpp"

#include "catch.hpp"

using namespace plumbline;
using namespace plumbline::opencv;

namespace {

/// With the lowest `bits` set.
LineDescriptor descriptor(int bits) {
  LineDescriptor out{};
  for (int i = 0; i < bits; ++i) out[static_cast<std::size_t>(i / 64)] |= std::uint64_t(1) << (i % 64);
  return out;
}

LineSegment segment(float angle_deg, float length = 100, float x = 0) {
  const float angle = angle_deg * 0.017453293f;
  const Vec<float, 2> center(x, 50), half(0.5f * length * std::cos(angle), 0.5f * length * std::sin(angle));
  return {center - half, center + half, 5};
}

/// Distance of the match between one segment and another; -1 without.
int match(const LineSegment& a, int bits_a, const LineSegment& b, int bits_b, const LineMatchOptions& options = {}) {
  const LineDescriptor da = descriptor(bits_a), db = descriptor(bits_b);
  const std::vector<LineMatch> matches = match_lines({&a, 1}, {&da, 1}, {&b, 1}, {&db, 1}, options);
  return matches.empty() ? -1 : matches[0].distance;
}

}  // namespace

TEST_CASE("line_matching: distances count bits") {
  REQUIRE(hamming_distance(descriptor(0), descriptor(256)) == 256);
  REQUIRE(hamming_distance(descriptor(63), descriptor(130)) == 67);
  REQUIRE(hamming_distance(descriptor(77), descriptor(77)) == 0);
}

TEST_CASE("line_matching: the limits of the paper") {
  REQUIRE(match(segment(10), 100, segment(10), 159) == 59);
  REQUIRE(match(segment(10), 100, segment(10), 160) == -1);
  REQUIRE(match(segment(10), 100, segment(39.9f), 100) == 0);
  REQUIRE(match(segment(10), 100, segment(40.1f), 100) == -1);
  REQUIRE(match(segment(170), 100, segment(-170), 100) == 0);
  REQUIRE(match(segment(10), 100, segment(190), 100) == -1);  // the other polarity
  REQUIRE(match(segment(0), 0, segment(0, 1000, 1e4f), 30) == 30);
}

TEST_CASE("line_matching: limits of length, shift and angle, and NaN") {
  LineMatchOptions options;
  options.min_length_ratio = 0.5f;
  REQUIRE(match(segment(0, 100), 0, segment(0, 51), 9, options) == 9);
  REQUIRE(match(segment(0, 49), 0, segment(0, 100), 9, options) == -1);
  options.max_shift_px = 20;
  REQUIRE(match(segment(0), 0, segment(0, 100, 19), 9, options) == 9);
  REQUIRE(match(segment(0), 0, segment(0, 100, 21), 9, options) == -1);
  options.max_angle_rad = 0.1f;
  REQUIRE(match(segment(0), 0, segment(6), 9, options) == -1);
  REQUIRE(match(segment(0), 0, segment(std::nanf("")), 0) == -1);
  options = {};
  options.max_distance = 1000;
  REQUIRE(match(segment(0), 0, segment(0), 256, options) == 256);
  REQUIRE(match(segment(0), 0, segment(90), 0, options) == -1);
}

TEST_CASE("line_matching: mutually nearest ones, each once, in the order of the first") {
  const std::vector<LineSegment> first{segment(0), segment(1), segment(2)}, second{segment(1), segment(0)};
  const std::vector<LineDescriptor> a{descriptor(90), descriptor(200), descriptor(96)};
  const std::vector<LineDescriptor> b{descriptor(100), descriptor(210)};
  const std::vector<LineMatch> matches = match_lines(first, a, second, b);
  REQUIRE(matches.size() == 2);  // first[0] is near second[0], too, but first[2] is nearer
  REQUIRE((matches[0].first == 1 && matches[0].second == 1 && matches[0].distance == 10));
  REQUIRE((matches[1].first == 2 && matches[1].second == 0 && matches[1].distance == 4));
  REQUIRE(match_lines({}, {}, second, b).empty());
  REQUIRE(match_lines(first, a, {}, {}).empty());
}

TEST_CASE("line_matching: a second one as near makes a match ambiguous, from either side") {
  const std::vector<LineSegment> one{segment(0)}, two{segment(0), segment(0)};
  const std::vector<LineDescriptor> of_one{descriptor(100)}, of_two{descriptor(110), descriptor(88)};  // 10 and 12 bits
  const std::vector<LineDescriptor> of_one_twice{descriptor(100), descriptor(100)};
  LineMatchOptions options;
  REQUIRE(match_lines(one, of_one, two, of_two, options).empty());
  REQUIRE(match_lines(two, of_two, one, of_one, options).empty());
  REQUIRE(match_lines(one, of_one, two, of_one_twice, options).empty());
  options.max_ratio = 0.84f;
  REQUIRE(match_lines(one, of_one, two, of_two, options).size() == 1);
  REQUIRE(match_lines(two, of_two, one, of_one, options).size() == 1);
}
