// Which points lie on which segments.
#include "plumbline/frontend/points_on_segments.hpp"

#include <cstdint>
#include <vector>

#include "catch.hpp"

using namespace plumbline;

namespace {

struct Member {
  std::uint32_t id;
  int hint = 0;
};
using Members = FixedVector<Member, 4>;

struct Point {
  struct {
    bool valid = true;
    Vec<float, 2> pixel;
  } current;
  std::uint32_t id;
};
struct Points {
  std::vector<Point> list;
  const std::vector<Point>& landmarks() const { return list; }
  void add(float u, float v) { list.push_back({{true, {u, v}}, std::uint32_t(10 + list.size())}); }
};

LineSegment segment(float u0, float v0, float u1, float v1) {
  LineSegment out;
  out.start = {u0, v0};
  out.end = {u1, v1};
  return out;
}

}  // namespace

TEST_CASE("points_on_segments: beside a segment, at its corner, beyond its end, out of sight") {
  const std::vector<LineSegment> segments{segment(0, 0, 100, 0), segment(100, 0, 100, 80)};
  Points points;
  points.add(50, 3);    // on the first
  points.add(99, 1);    // at the corner
  points.add(-6, 0);    // beyond the end, on its line
  points.add(102, 40);  // on the second
  points.add(70, 5);    // too far
  points.add(20, 0);
  points.list.back().current.valid = false;

  PointsOnSegments<Members> on;
  on.associate(points, segments, 4);
  const Members first = on.of(0, points), second = on.of(1, points);
  REQUIRE(first.size() == 2);
  REQUIRE((first[0].id == 10 && first[0].hint == 0 && first[1].id == 11));
  REQUIRE(second.size() == 2);
  REQUIRE((second[0].id == 11 && second[1].id == 13 && second[1].hint == 3));
}

TEST_CASE("points_on_segments: a point on three segments is on none, and there is room for so many") {
  const std::vector<LineSegment> segments{segment(0, 0, 100, 0), segment(0, 0, 0, 80), segment(0, 0, 50, 50)};
  Points points;
  points.add(1, 1);
  for (int i = 1; i < 8; ++i) points.add(10 * float(i) + 5, 0);
  PointsOnSegments<Members, 6> on;  // the last two are not heard
  on.associate(points, segments, 4);
  REQUIRE(on.of(1, points).empty());
  REQUIRE(on.of(0, points).size() == 4);
  REQUIRE(on.of(0, points)[0].id == 11);
}
