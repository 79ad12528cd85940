#include "plumbline/map/point_set.hpp"

#include <memory>
#include <set>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

PlaceKeyframe<double, 50> seeing(Random& random, std::uint32_t most) {
  PlaceKeyframe<double, 50> out;
  for (int n = 0; n < 50; ++n) {
    PlaceFeature feature;
    if (n % 5 > 0) feature.point = random.below(most);
    out.features.push_back(feature);
  }
  return out;
}

}  // namespace

TEST_CASE("point_set: finds the points of its keyframes, and no others") {
  Random random(1);
  for (const std::uint32_t most : {60u, 4000u, 1000000u}) {
    const auto a = seeing(random, most), b = seeing(random, most), c = seeing(random, most);
    PointSet<100> set;
    set.add(a);
    set.add(b);
    set.sort();
    std::set<std::uint32_t> expected;
    for (const auto* keyframe : {&a, &b}) {
      for (const PlaceFeature& feature : keyframe->features) {
        if (feature.point != PlaceFeature::no_point) expected.insert(feature.point);
      }
    }
    REQUIRE(set.size() == expected.size());
    std::size_t n = 0;
    for (const std::uint32_t point : expected) {
      CHECK(set[n] == point);
      CHECK(set.find(point) == int(n++));
    }
    int shared = 0;
    for (const PlaceFeature& feature : c.features) {
      const bool is_seen = expected.count(feature.point) > 0;
      shared += is_seen;
      if (feature.point != PlaceFeature::no_point) CHECK((set.find(feature.point) != set.none) == is_seen);
    }
    CHECK(set.count_seen(c) == shared);
    set.clear();
    CHECK(set.size() == 0);
    CHECK(set.count_seen(a) == 0);
  }
}

TEST_CASE("point_set: full, it keeps what it has") {
  Random random(2);
  PointSet<30> set;
  set.add(seeing(random, 1000000));
  set.sort();
  CHECK(set.size() == 30);
}
