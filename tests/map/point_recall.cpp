// Corners of a rendered room whose ranges are known from one view, expected in another one by a pose that is a little
// wrong.
#include "plumbline/map/point_recall.hpp"

#include <memory>
#include <vector>

#include "../estimator/simulation.hpp"
#include "catch.hpp"
#include "plumbline/map/place_graph.hpp"
#include "plumbline/residual/relative_sim3.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/tracking/corner_maxima.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t max_pixels = test::SimulatedRgbd::width * test::SimulatedRgbd::height;
using Sensors = Rig<Mono<Pinhole<double>, max_pixels>>;
using Places = PlaceGraph<RelativeSim3Residual<double>, 8, 200, 4>;
using Points = MapPoints<Places, 300>;

const test::SimulatedRgbd& world() {
  static const test::SimulatedRgbd seen(9, 3, 10);
  return seen;
}
const RigPyramid<Sensors>& image(std::size_t frame) {
  static std::vector<std::unique_ptr<RigPyramid<Sensors>>> all(world().frames.size());
  if (!all[frame]) {
    all[frame] = std::make_unique<RigPyramid<Sensors>>();
    REQUIRE(all[frame]->build(world().frames[frame].gray.view()));
  }
  return *all[frame];
}

struct Scene {
  Sensors rig{};
  std::unique_ptr<Places> places = std::make_unique<Places>(PlaceGraphOptions{});
  std::unique_ptr<Points> points = std::make_unique<Points>();
  std::unique_ptr<PointRecall<Sensors, Places, 100>> recall;

  Scene() {
    rig.vision.camera = world().camera;
    rig.vision.width = world().width;
    rig.vision.height = world().height;
    recall = std::make_unique<PointRecall<Sensors, Places, 100>>(rig, PointRecallOptions{});
    add(0, SE3<double>());
    FixedVector<Corner, 100> corners;
    detect_corner_maxima<100>(image(0).level(0), {}, {}, 100, corners);
    REQUIRE(corners.size() > 50);
    for (const Corner& corner : corners) {
      ReferencePatch patch;
      const double depth = depth_at(corner.uv);
      if (!(depth > 0) || !patch.capture(image(0), corner.uv)) continue;
      see(0, corner.uv, depth / world().camera.unproject(cast_to<double>(corner.uv)).bearing.z());
      points->add(*places, 0, places->keyframe(0).features.size() - 1, patch);
    }
    places->retire(1, places->keyframe(0).T_world_body);
  }
  /// In millimeters.
  static double depth_at(const Vec<float, 2>& uv) {
    return world().frames[0].depth.view()(int(std::lround(uv.x())), int(std::lround(uv.y()))) / 1000.0;
  }
  /// A keyframe of that frame, whose pose is off by `error`.
  void add(std::size_t frame, const SE3<double>& error) {
    const auto id = std::uint32_t(places->size() + 1);
    Mat<double, 6, 6> P = 1e-6 * Mat<double, 6, 6>::Identity();
    REQUIRE(places->add(id, TimeNs(id), world().T_world_cam[frame] * error, {}, P));
  }
  void see(int k, const Vec<float, 2>& uv, double range) {
    PlaceFeature feature;
    feature.bearing = cast_to<float>(world().camera.unproject(cast_to<double>(uv)).bearing);
    feature.sigma_rad = 0.002f;
    feature.range = float(range);
    feature.sigma_range = 0.01f * feature.range;
    REQUIRE(places->keyframe(k).features.push_back(feature));
  }
  Vec<double, 2> truth(std::size_t frame, std::uint32_t point) const {
    const PlaceFeature& feature = places->keyframe(0).features[(*points)[point].feature];
    const Vec<double, 3> p = double(feature.range) * cast_to<double>(feature.bearing);
    return world().camera.project(world().T_world_cam[frame].inverse() * (world().T_world_cam[0] * p)).uv;
  }
};

}  // namespace

TEST_CASE("point_recall: points of an older view are found in a newer one, though its pose is a little wrong") {
  Scene scene;
  const std::size_t frame = 8;
  const SE3<double> error(SO3<double>::exp({0.006, -0.008, 0.004}), Vec<double, 3>(0.01, -0.01, 0.01));
  scene.add(frame, error);
  scene.see(1, {20, 20}, 0);  // what the view covers
  scene.see(1, {300, 220}, 0);
  const auto again = scene.recall->recall(*scene.places, *scene.points, 1, image(frame));
  REQUIRE(again.size() > 20);
  std::vector<double> errors;
  for (const RecalledPoint& point : again) {
    errors.push_back((cast_to<double>(point.pixel) - scene.truth(frame, point.point)).norm());
    CHECK(errors.back() < 3);
    CHECK(point.sigma_px > 0);
  }
  std::nth_element(errors.begin(), errors.begin() + std::ptrdiff_t(errors.size() / 2), errors.end());
  CHECK(errors[errors.size() / 2] < 0.8);
}

TEST_CASE("point_recall: what the keyframe sees already is not asked for, and nothing is found in another image") {
  Scene scene;
  scene.add(8, SE3<double>());
  scene.see(1, {20, 20}, 0);
  scene.see(1, {300, 220}, 0);
  scene.points->observe(*scene.places, 1, 0, scene.places->keyframe(0).features[0].point);
  for (const RecalledPoint& point : scene.recall->recall(*scene.places, *scene.points, 1, image(8)))
    CHECK(point.point != scene.places->keyframe(0).features[0].point);

  Scene other;
  other.add(8, SE3<double>());
  other.see(1, {20, 20}, 0);
  other.see(1, {300, 220}, 0);
  auto dark = std::make_unique<RigPyramid<Sensors>>();
  const std::vector<std::uint8_t> pixels(max_pixels, 40);
  REQUIRE(dark->build({pixels.data(), world().width, world().height, world().width}));
  CHECK(other.recall->recall(*other.places, *other.points, 1, *dark).empty());
}
