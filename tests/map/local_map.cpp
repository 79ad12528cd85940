// What a camera at some pose may see of the map: the nearest keyframes, each landmark once, in one unit.
#include "plumbline/map/local_map.hpp"

#include <algorithm>
#include <memory>
#include <vector>

#include "catch.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "simulated_places.hpp"

using namespace plumbline;
using test::looking_along;

namespace {

using Places = PlaceGraph<RelativeSim3Residual<double>, 30, 200, 10>;

struct Map {
  test::SimulatedPlaces points{1};
  std::unique_ptr<Places> places = std::make_unique<Places>(PlaceGraphOptions{});
  LocalMap<Places, 400> local;
  PlaceKeyframe<double, 400> frame;
  int overlapping = 0;

  explicit Map(int count = 12) {
    points.sigma_rad = points.relative_sigma_range = 1e-6;
    points.furnish(600, 4);
    for (int k = 0; k < count; ++k) {
      const SE3<double> T = looking_along(2 * 3.14159265358979 * k / count, {0, 0, 0});
      Mat<double, 6, 6> covariance = identity<double, 6>();
      REQUIRE(places->add(std::uint32_t(k + 1), k, T, {}, covariance));
      points.look(T, places->keyframe(k).features);
      for (PlaceFeature& feature : places->keyframe(k).features) {  // the same point has the same number in all
        const Vec<double, 3> p = T * Vec<double, 3>(double(feature.range) * cast_to<double>(feature.bearing));
        double best = 1;
        for (std::size_t n = 0; n < points.points.size(); ++n) {
          const double d = norm(Vec<double, 3>(points.points[n].p - p));
          if (d < best) {
            best = d;
            feature.landmark = std::uint32_t(n);
          }
        }
      }
      places->retire(std::uint32_t(k + 1), T);
    }
    places->update();
    points.look(looking_along(0.1, {0, 0, 0}), frame.features);
  }
  void collect(const SE3<double>& T, auto&& accept) {
    overlapping = 0;
    local.collect(*places, T, frame, {}, 0.3, accept, [this](int) { ++overlapping; });
  }
};

}  // namespace

TEST_CASE("local_map: has the points before the camera, each once, where they are") {
  Map map;
  const SE3<double> T = looking_along(0.1, {0.1, 0, 0});
  map.collect(T, [](const auto&) { return true; });
  auto& features = map.local.keyframe.features;
  REQUIRE(features.size() > map.frame.features.size());
  CHECK(map.overlapping >= 3);
  std::vector<std::uint32_t> ids;
  for (const PlaceFeature& feature : features) {
    ids.push_back(feature.landmark);
    const Vec<double, 3> p =
        map.local.T_map_local * Vec<double, 3>(double(feature.range) * cast_to<double>(feature.bearing));
    CHECK(norm(Vec<double, 3>(p - map.points.points[feature.landmark].p)) < 0.001);
  }
  std::sort(ids.begin(), ids.end());
  CHECK(std::adjacent_find(ids.begin(), ids.end()) == ids.end());
  CHECK(norm(Vec<double, 3>(map.local.T_map_local.p())) < 1e-6);  // the camera of the nearest keyframe
}

TEST_CASE("local_map: only of keyframes that are accepted, and of none that looks elsewhere") {
  Map map;
  map.collect(looking_along(0.1, {0, 0, 0}), [](const auto& keyframe) { return keyframe.id == 1; });
  CHECK(map.overlapping == 1);
  CHECK(map.local.keyframe.features.size() == map.places->keyframe(0).features.size());
  map.collect(looking_along(3.1, {0, 0, 0}), [](const auto& keyframe) { return keyframe.id == 1; });
  CHECK(map.overlapping == 0);
  CHECK(map.local.keyframe.features.size() == 0);
}

TEST_CASE("local_map: ranges that are hardly known, and those that are not, are left out") {
  Map map(1);
  for (PlaceFeature& feature : map.places->keyframe(0).features) feature.sigma_range = 0.4f * feature.range;
  map.places->keyframe(0).features[0].sigma_range = 0;
  map.places->keyframe(0).features[1].range = 0;
  map.collect(looking_along(0, {0, 0, 0}), [](const auto&) { return true; });
  CHECK(map.local.keyframe.features.size() == 1);
}
