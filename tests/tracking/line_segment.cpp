#include "plumbline/tracking/line_segment.hpp"

#include "catch.hpp"

using namespace plumbline;
using Vec2f = Vec<float, 2>;

TEST_CASE("line_segment: the normal is a quarter turn from the direction, x to y") {
  const LineSegment s{Vec2f(1, 2), Vec2f(4, 6), 5};
  REQUIRE(s.length() == Approx(5));
  REQUIRE((s.direction() - Vec2f(0.6f, 0.8f)).norm() < 1e-6f);
  REQUIRE((s.normal() - Vec2f(-0.8f, 0.6f)).norm() < 1e-6f);
  REQUIRE((s.center() - Vec2f(2.5f, 4)).norm() < 1e-6f);
  REQUIRE(s.distance(Vec2f(1, 2) + 3 * s.normal() + 7 * s.direction()) == Approx(3));
}

TEST_CASE("line_segment: parts of one edge are one, others are not") {
  const MergeOptions options;
  const LineSegment a{Vec2f(0, 0), Vec2f(40, 0), 10};
  const auto one = [&](const LineSegment& b) { return are_one(a, b, options) && are_one(b, a, options); };
  const auto none = [&](const LineSegment& b) { return !are_one(a, b, options) && !are_one(b, a, options); };
  REQUIRE(one({Vec2f(45, 0.3f), Vec2f(75, 0.5f), 10}));   // a small gap
  REQUIRE(one({Vec2f(20, 0.3f), Vec2f(75, 0.5f), 10}));   // overlap
  REQUIRE(one({Vec2f(10, 0.3f), Vec2f(30, 0.5f), 10}));   // within
  REQUIRE(one({Vec2f(-40, 0), Vec2f(-5, 0), 10}));        // before
  REQUIRE(none({Vec2f(75, 0.5f), Vec2f(45, 0.3f), 10}));  // opposite polarity
  REQUIRE(none({Vec2f(60, 0), Vec2f(100, 0), 10}));       // too large a gap
  REQUIRE(none({Vec2f(45, 0), Vec2f(51, 0), 10}));        // a gap too large for so short a piece
  REQUIRE(none({Vec2f(45, 3), Vec2f(75, 3), 10}));        // parallel
  REQUIRE(none({Vec2f(45, 0), Vec2f(75, 4), 10}));        // at an angle
  const float nan = std::nanf("");
  REQUIRE(none({Vec2f(nan, 0), Vec2f(75, 0), 10}));
}

TEST_CASE("line_segment: merging keeps the line and the whole extent") {
  const Vec2f d = Vec2f(0.6f, 0.8f), p(30, 20);
  const LineSegment a{p, p + 20 * d, 8}, b{p + 25 * d, p + 65 * d, 20};
  const LineSegment m = merged(a, b);
  REQUIRE((m.start - a.start).norm() < 1e-4f);
  REQUIRE((m.end - b.end).norm() < 1e-4f);
  REQUIRE(m.gradient == Approx((20 * 8 + 40 * 20) / 60.0));
  // parallel ones meet in between, nearer to the longer one
  const Vec2f n(-0.8f, 0.6f);
  const LineSegment c{p + 0.9f * n, p + 20 * d + 0.9f * n, 8};
  const LineSegment beside = merged(c, {p, p + 40 * d, 8});
  REQUIRE(std::abs(beside.direction().dot(n)) < 0.04f);
  REQUIRE(n.dot(beside.center() - p) == Approx(0.3f).margin(0.1f));
  REQUIRE(merged({a.end, a.start, 1}, {b.end, b.start, 1}).direction().dot(d) == Approx(-1));
}

TEST_CASE("line_segment: of many pieces each edge remains once, sorted by length") {
  FixedVector<LineSegment, 40> segments;
  for (int i = 0; i < 10; ++i) {  // two edges in pieces of 10 px with gaps of 2 px, interleaved
    const float t = 12.0f * static_cast<float>(i);
    segments.push_back({Vec2f(t, 50), Vec2f(t + 10, 50), 5});
    if (i < 5) segments.push_back({Vec2f(100, 10 + t), Vec2f(100, 20 + t), 7});
  }
  segments.push_back({Vec2f(300, 300), Vec2f(315, 310), 4});
  merge_collinear(segments, MergeOptions{});
  REQUIRE(segments.size() == 3);
  REQUIRE(segments[0].length() == Approx(118));
  REQUIRE(segments[1].length() == Approx(58));
  REQUIRE(std::abs(segments[0].distance(Vec2f(0, 50))) < 1e-4f);
}
