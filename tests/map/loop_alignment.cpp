// Patches of one view of a rendered room, aligned in another one whose pose is a little wrong.
#include "plumbline/map/loop_alignment.hpp"

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "../estimator/simulation.hpp"
#include "catch.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/tracking/corner_maxima.hpp"

using namespace plumbline;

namespace {

constexpr std::size_t max_pixels = test::SimulatedRgbd::width * test::SimulatedRgbd::height;
using Sensors = Rig<Mono<Pinhole<double>, max_pixels>>;
using Alignment = LoopAlignment<Sensors, 4, 40>;

struct Views {
  test::SimulatedRgbd world{5, 3, 10};
  Sensors rig{};
  PlaceKeyframe<double, 100> old;
  std::vector<Vec<float, 2>> pixels;
  RigPyramid<Sensors> first, second;
  std::unique_ptr<Alignment> alignment;
  SE3<double> T_old_current;

  Views() {
    rig.vision.camera = world.camera;
    rig.vision.width = world.width;
    rig.vision.height = world.height;
    REQUIRE(first.build(world.frames[0].gray.view()));
    REQUIRE(second.build(world.frames[4].gray.view()));
    T_old_current = world.T_world_cam[0].inverse() * world.T_world_cam[4];
    FixedVector<Corner, 100> corners;
    detect_corner_maxima<100>(first.level(0), {}, {}, 100, corners);
    for (const Corner& corner : corners) {
      const double depth =
          world.frames[0].depth.view()(int(std::lround(corner.uv.x())), int(std::lround(corner.uv.y()))) / 1000.0;
      if (!(depth > 0)) continue;
      const Vec<double, 3> bearing = world.camera.unproject(cast_to<double>(corner.uv)).bearing;
      PlaceFeature feature;
      feature.bearing = cast_to<float>(bearing);
      feature.range = float(depth / bearing.z());
      feature.sigma_range = 0.005f * feature.range;
      old.features.push_back(feature);
      pixels.push_back(corner.uv);
    }
    old.id = 7;
    alignment = std::make_unique<Alignment>(rig, LoopAlignmentOptions{});
    alignment->learn(2, old, first, [&](std::size_t n) { return pixels[n]; });
  }
  RigShutter<Sensors> shutter() const { return {rig.vision.camera, rig.vision.height, 0}; }
  /// Errors of the bearings [px], and their claimed sigmas.
  std::vector<double> errors(int slot, const SE3<double>& T, std::vector<double>& sigmas) const {
    std::vector<double> out;
    alignment->align(slot, old, T, [&](const PlaceFeature& feature, const Vec<double, 3>& bearing, double sigma_rad) {
      const Vec<double, 3> p = T_old_current.inverse() * (double(feature.range) * cast_to<double>(feature.bearing));
      out.push_back((world.camera.project(p).uv - world.camera.project(bearing).uv).norm());
      sigmas.push_back(sigma_rad * effective_focal_length(world.camera));
    });
    return out;
  }
};

double median(std::vector<double> of) {
  std::nth_element(of.begin(), of.begin() + std::ptrdiff_t(of.size() / 2), of.end());
  return of[of.size() / 2];
}

}  // namespace

TEST_CASE("loop_alignment: patches are found to a fraction of a pixel, though the pose is off by one") {
  Views views;
  std::vector<double> sigmas;
  CHECK(views.errors(2, views.T_old_current, sigmas).empty());  // no image yet
  views.alignment->set_image(views.second, views.shutter());
  const SE3<double> off(SO3<double>::exp({0.002, -0.003, 0.001}), Vec<double, 3>(0.003, -0.003, 0.003));
  const std::vector<double> errors = views.errors(2, views.T_old_current * off, sigmas);
  REQUIRE(errors.size() > 15);
  CHECK(median(errors) < 0.5);
  CHECK(median(sigmas) > 0.05);
  CHECK(median(sigmas) < 0.5);
}

TEST_CASE("loop_alignment: patches are those of the keyframe in the slot, and of what has a range") {
  Views views;
  views.alignment->set_image(views.second, views.shutter());
  std::vector<double> sigmas;
  CHECK(views.errors(1, views.T_old_current, sigmas).empty());
  views.old.id = 8;  // another keyframe has been there
  CHECK(views.errors(2, views.T_old_current, sigmas).empty());
  views.old.id = 7;
  const std::size_t before = views.errors(2, views.T_old_current, sigmas).size();
  for (std::size_t n = 0; n < views.old.features.size(); n += 2) views.old.features[n].range = 0;
  const std::size_t after = views.errors(2, views.T_old_current, sigmas).size();
  CHECK(after < before);
  CHECK(after > 0);
}

TEST_CASE("loop_alignment: nothing is found in a dark image or behind the camera, and NaN is none") {
  Views views;
  std::vector<double> sigmas;
  views.alignment->set_image(views.second, views.shutter());
  const SE3<double> behind(SO3<double>::exp({0, 3.1, 0}), Vec<double, 3>(0, 0, 0));
  CHECK(views.errors(2, views.T_old_current * behind, sigmas).empty());
  SE3<double> broken(views.T_old_current.rotation(), Vec<double, 3>(std::nan(""), 0, 0));
  CHECK(views.errors(2, broken, sigmas).empty());
  std::vector<std::uint8_t> black(max_pixels, 0);
  RigPyramid<Sensors> dark;
  REQUIRE(dark.build({black.data(), views.world.width, views.world.height, views.world.width}));
  views.alignment->set_image(dark, views.shutter());
  CHECK(views.errors(2, views.T_old_current, sigmas).empty());
}
