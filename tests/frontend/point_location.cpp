#include "plumbline/frontend/point_location.hpp"

#include <array>
#include <limits>
#include <memory>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/feature/landmark.hpp"
#include "plumbline/feature/point_kind.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

/// A point before cameras that move sideways; slot 0 is its anchor.
template <class S>
struct Scene {
  static constexpr int slots = 4;
  using Sensors = Rig<Rgbd<Pinhole<S>, 64 * 48>>;
  using Landmark = plumbline::Landmark<PointKind<Sensors>, slots>;

  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> pyramid = std::make_unique<RigPyramid<Sensors>>();
  std::array<SE3<S>, slots> poses;
  SE3<S> T_world_latest{{}, {S(0.4), S(0), S(0.1)}}, T_body_cam{SO3<S>::exp({0, S(0.1), 0}), {S(0.1), 0, 0}};
  Vec<S, 3> p_world{S(0.3), S(-0.2), S(3)};
  Landmark landmark{};

  Scene() {
    rig.vision.camera = {S(60), S(60), S(31.5), S(23.5), {}};
    for (int slot = 0; slot < slots; ++slot) poses[std::size_t(slot)] = SE3<S>({}, {S(0.1 * slot), S(0), S(0)});
    landmark.anchor = 0;
    landmark.geometry.bearing = bearing(poses[0], p_world);
  }
  const SE3<S>& T_world_body(int slot) const { return poses[std::size_t(slot)]; }  ///< it is the window, too
  Vec<S, 3> p_cam(const SE3<S>& T_world, const Vec<S, 3>& p) const { return (T_world * T_body_cam).inverse() * p; }
  Vec<S, 3> bearing(const SE3<S>& T_world, const Vec<S, 3>& p) const { return normalized(p_cam(T_world, p)); }
  SE3<S> T_latest_anchor() const { return (T_world_latest * T_body_cam).inverse() * (poses[0] * T_body_cam); }
  S inverse_range() const { return S(1) / norm(p_cam(poses[0], p_world)); }
  void see(int slot, const Vec<S, 3>& p) {
    auto& seen = landmark.observations[std::size_t(slot)];
    seen.valid = true;
    seen.uv = cast_to<float>(rig.vision.camera.project(p_cam(poses[std::size_t(slot)], p)).uv);
  }
  void locate_by_depth(S inverse_depth, S sigma = S(0.01), bool valid = true) {
    landmark.current.depth.set({valid, inverse_depth, sigma});
    locate_from_depth(landmark, bearing(T_world_latest, p_world), T_latest_anchor());
  }
  void locate_by_views(int min_views, S sigma_rad = S(1e-3)) {
    const View<Sensors> view{0, S(0), rig, *pyramid, *pyramid, {}, {}, T_body_cam, {rig.vision.camera, 48, S(0)}};
    locate_from_views(landmark, view, *this, bearing(T_world_latest, p_world), T_latest_anchor(), sigma_rad, min_views,
                      TriangulationOptions{});
  }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-6;  // pixels are float in both

}  // namespace

TEMPLATE_TEST_CASE("point_location: the depth of a later frame gives the range in the anchor", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  const S z = scene.p_cam(scene.T_world_latest, scene.p_world).z();
  scene.locate_by_depth(S(1) / z);
  REQUIRE(scene.landmark.located);
  CHECK(scene.landmark.geometry.inverse_range == Approx(scene.inverse_range()).epsilon(tolerance<S>));
  const S b_z = scene.bearing(scene.T_world_latest, scene.p_world).z();
  CHECK(scene.landmark.geometry.sigma_inverse_range == Approx(S(0.01) * b_z));
}

TEMPLATE_TEST_CASE("point_location: a depth that is none, or of what lies beside the anchor's ray, locates nothing", "",
                   float, double) {
  using S = TestType;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  Scene<S> scene;
  const S inverse_depth = S(1) / scene.p_cam(scene.T_world_latest, scene.p_world).z();
  scene.locate_by_depth(inverse_depth, S(0.01), false);
  CHECK_FALSE(scene.landmark.located);
  scene.locate_by_depth(nan);
  CHECK_FALSE(scene.landmark.located);
  scene.locate_by_depth(2 * inverse_depth);  // half as far, 5 degrees aside
  CHECK_FALSE(scene.landmark.located);
  CHECK(scene.landmark.geometry.inverse_range == S(0));
  scene.locate_by_depth(inverse_depth);
  CHECK(scene.landmark.located);
}

TEMPLATE_TEST_CASE("point_location: two views with parallax triangulate, without it they do not", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  scene.locate_by_views(1);
  REQUIRE(scene.landmark.located);
  CHECK(scene.landmark.geometry.inverse_range == Approx(scene.inverse_range()).epsilon(tolerance<S>));
  CHECK(scene.landmark.geometry.sigma_inverse_range > 0);
  Scene<S> still;
  still.T_world_latest = still.poses[0];
  still.locate_by_views(1);
  CHECK_FALSE(still.landmark.located);
}

TEST_CASE("point_location: where more views are asked for, those of keyframes count, but not the anchor's") {
  Scene<double> scene;
  scene.see(0, scene.p_world);
  scene.see(1, scene.p_world);
  scene.locate_by_views(3);  // the latest frame and one keyframe
  CHECK_FALSE(scene.landmark.located);
  scene.see(3, scene.p_world);
  scene.locate_by_views(3);
  REQUIRE(scene.landmark.located);
  const double of_three = scene.landmark.geometry.sigma_inverse_range;
  CHECK(scene.landmark.geometry.inverse_range == Approx(scene.inverse_range()).epsilon(1e-6));
  scene.locate_by_views(1);
  CHECK(scene.landmark.geometry.sigma_inverse_range > of_three);  // the latest frame alone
}

TEST_CASE("point_location: views that see different points agree on none") {
  Scene<double> scene;
  scene.see(1, scene.p_world);
  scene.see(3, scene.p_world + Vec<double, 3>(0, 0.3, 0));  // a point that moved
  scene.locate_by_views(3);
  CHECK_FALSE(scene.landmark.located);
}
