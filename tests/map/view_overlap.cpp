#include "plumbline/map/view_overlap.hpp"

#include <limits>

#include "catch.hpp"
#include "simulated_places.hpp"

using namespace plumbline;

namespace {

using Keyframe = PlaceKeyframe<double, 600>;

struct Views {
  test::SimulatedPlaces places{3};

  Views() { places.furnish(1500, 6); }
  Keyframe at(const SE3<double>& T_world_cam, double scale = 1) {
    Keyframe out;
    places.look(T_world_cam, out.features, scale);
    REQUIRE(out.features.size() > 50);
    return out;
  }
};

}  // namespace

TEST_CASE("view_overlap: all of the same view, part of a turned one, nothing behind") {
  Views views;
  const SE3<double> T = test::looking_along(0.3, {0.5, 0.2, 0});
  const Keyframe keyframe = views.at(T);
  const auto overlap = [&](const SE3<double>& other) {
    return view_overlap(keyframe, Sim3<double>(other.inverse() * T), SeenRectangle(views.at(other)));
  };
  CHECK(overlap(T) > 0.95);
  const double turned = overlap(test::looking_along(0.8, {0.5, 0.2, 0}));
  CHECK(turned > 0.3);
  CHECK(turned < 0.8);
  CHECK(overlap(test::looking_along(0.3 + 3.14, {0.5, 0.2, 0})) == 0);
}

TEST_CASE("view_overlap: not what is seen from much nearer, or from another side") {
  Views views;
  const SE3<double> far = test::looking_along(0, {-4, 0, 0});
  const Keyframe keyframe = views.at(far);
  const auto overlap = [&](const SE3<double>& other) {
    return view_overlap(keyframe, Sim3<double>(other.inverse() * far), SeenRectangle(views.at(other)));
  };
  CHECK(overlap(test::looking_along(0, {-3, 0, 0})) > 0.5);
  CHECK(overlap(test::looking_along(0, {3, 0, 0})) < 0.1);
  CHECK(overlap(test::looking_along(1.2, {4, -5.5, 0})) < 0.1);
}

TEST_CASE("view_overlap: units may differ; without ranges, and with poses that are not finite, there is none") {
  Views views;
  const SE3<double> T = test::looking_along(0.3, {0.5, 0.2, 0});
  Keyframe keyframe = views.at(T, 4);  // ranges in quarters of a meter
  const SeenRectangle seen(views.at(T));
  CHECK(view_overlap(keyframe, Sim3<double>(0.25, SO3<double>(), Vec<double, 3>(0, 0, 0)), seen) > 0.95);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(view_overlap(keyframe, Sim3<double>(1, SO3<double>(), Vec<double, 3>(nan, 0, 0)), seen) == 0);
  for (PlaceFeature& feature : keyframe.features) feature.range = 0;
  CHECK(view_overlap(keyframe, Sim3<double>(), seen) == 0);
}
