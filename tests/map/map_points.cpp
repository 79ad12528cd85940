#include "plumbline/map/map_points.hpp"

#include <map>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_sim3.hpp"

using namespace plumbline;

namespace {

using Places = PlaceGraph<RelativeSim3Residual<double>, 8, 10, 4>;
constexpr std::uint32_t no_point = PlaceFeature::no_point;

struct World {
  std::unique_ptr<Places> places = std::make_unique<Places>(PlaceGraphOptions{});
  std::unique_ptr<MapPoints<Places, 12>> points = std::make_unique<MapPoints<Places, 12>>();
  std::uint32_t id = 0;
  ReferencePatch patch;

  World() {
    static std::vector<std::uint8_t> pixels(100 * 100, 90);
    const auto pyramid = std::make_unique<Pyramid<3, 100 * 100>>();
    REQUIRE(pyramid->build({pixels.data(), 100, 100, 100}));
    REQUIRE(patch.capture(*pyramid, {50, 50}));
  }
  /// A keyframe that tracks these landmarks.
  int add(const std::vector<std::uint32_t>& landmarks) {
    ++id;
    const SE3<double> T(SO3<double>(), Vec<double, 3>(0.1 * id, 0, 0));
    REQUIRE(places->add(id, TimeNs(id), T, {}, Mat<double, 6, 6>(1e-6 * Mat<double, 6, 6>::Identity())));
    const int k = places->size() - 1;
    for (const std::uint32_t landmark : landmarks) {
      PlaceFeature feature;
      feature.landmark = landmark;
      feature.range = 2;
      feature.sigma_range = 0.1f;
      places->keyframe(k).features.push_back(feature);
    }
    points->take_tracks(*places, k);
    return k;
  }
  std::uint32_t& point(int k, std::size_t feature) { return places->keyframe(k).features[feature].point; }
  void make(int k, std::size_t feature) { points->add(*places, k, feature, patch); }
  /// The counts are those of the features.
  void check() {
    std::map<std::uint32_t, int> seen;
    for (int k = 0; k < places->size(); ++k) {
      for (const PlaceFeature& feature : places->keyframe(k).features) {
        if (feature.point != no_point) ++seen[feature.point];
      }
    }
    CHECK(points->size() == seen.size());
    for (const auto& [point, count] : seen) CHECK((*points)[point].observations == count);
  }
};

}  // namespace

TEST_CASE("map_points: a landmark that is tracked on is the same point, a lost one is not") {
  World world;
  const int a = world.add({1, 2, 3});
  for (std::size_t n = 0; n < 3; ++n) world.make(a, n);
  const int b = world.add({3, 4, 1});
  CHECK(world.point(b, 0) == world.point(a, 2));
  CHECK(world.point(b, 1) == no_point);
  CHECK(world.point(b, 2) == world.point(a, 0));
  for (int n = 0; n < 3; ++n) world.add({});
  const int c = world.add({1});
  CHECK(world.point(c, 0) == no_point);
  world.check();
  CHECK((*world.points)[world.point(a, 0)].slot == world.places->slot(a));
  CHECK((*world.points)[world.point(a, 0)].patch.levels() == 2);
}

TEST_CASE("map_points: two points become one where no keyframe sees both") {
  World world;
  const int a = world.add({1, 2});
  const int b = world.add({1, 3});
  world.make(a, 0);
  world.make(a, 1);
  world.make(b, 0);
  world.make(b, 1);
  REQUIRE(world.point(a, 0) != world.point(b, 0));
  const int c = world.add({3});
  REQUIRE(world.point(c, 0) == world.point(b, 1));
  world.points->join(*world.places, a, b, std::vector<DescriptorMatch>{{0, 0, 0}, {1, 1, 0}});
  CHECK(world.point(a, 0) == world.point(b, 0));
  CHECK(world.point(a, 1) == world.point(b, 1));
  CHECK(world.point(c, 0) == world.point(a, 1));  // as far as it was tracked
  CHECK(world.places->keyframe(b).features[0].is_recalled);
  world.check();
  // a sees both of them
  const std::uint32_t first = world.point(a, 0), second = world.point(a, 1);
  world.points->join(*world.places, a, c, std::vector<DescriptorMatch>{{0, 0, 0}});
  CHECK(world.point(a, 0) == first);
  CHECK(world.point(c, 0) == second);
  world.check();
}

TEST_CASE("map_points: a point found again is that of the feature, and asked for once a keyframe") {
  World world;
  const int a = world.add({1, 2});
  world.make(a, 0);
  for (int n = 0; n < 3; ++n) world.add({});
  const int b = world.add({7, 8});
  const std::uint32_t point = world.point(a, 0);
  CHECK(world.points->ask(point, world.id));
  CHECK_FALSE(world.points->ask(point, world.id));
  CHECK(world.points->ask(point, world.id + 1));
  world.points->observe(*world.places, b, 0, point);
  CHECK(world.point(b, 0) == point);
  world.points->observe(*world.places, b, 1, point);  // one feature of a keyframe only
  CHECK(world.point(b, 1) == no_point);
  const int c = world.add({7});
  CHECK(world.point(c, 0) == point);
  CHECK_FALSE(world.places->keyframe(c).features[0].is_recalled);
  world.check();
}

TEST_CASE("map_points: room is what keyframes free; without room nothing new is learned") {
  World world;
  const int a = world.add({1, 2, 3, 4, 5, 6, 7, 8});
  for (std::size_t n = 0; n < 8; ++n) world.make(a, n);
  const int b = world.add({11, 12, 13, 14, 15, 16});
  for (std::size_t n = 0; n < 6; ++n) world.make(b, n);
  CHECK(world.points->size() == 12);
  CHECK(world.point(b, 4) == no_point);
  world.check();
  world.places->keyframe(b).features[0].range = 0;
  world.points->drop_unlocated(world.places->keyframe(b));
  CHECK(world.point(b, 0) == no_point);
  CHECK(world.points->size() == 11);
  const std::uint32_t shared = world.point(a, 0);
  world.places->keyframe(b).features[5].point = no_point;
  world.points->observe(*world.places, b, 5, shared);
  world.points->forget(world.places->keyframe(a), world.places->slot(a));
  CHECK(world.points->size() == 4);
  CHECK((*world.points)[shared].observations == 1);
  CHECK((*world.points)[shared].slot == Places::none);  // its patch is of that keyframe's view
}
