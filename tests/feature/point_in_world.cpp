#include "plumbline/feature/point_in_world.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/sensor/mono.hpp"
#include "plumbline/sensor/rgbd.hpp"

using namespace plumbline;

namespace {

/// A point two meters before a camera that is its body, seen 3 px beside where it is.
template <class S>
struct Scene {
  using Sensors = Rig<Rgbd<Pinhole<S>, 64 * 64>>;
  Sensors rig{};
  PointInWorld<Sensors> point;
  BodyView<S> view{SE3<S>(), SE3<S>()};

  Scene() {
    rig.vision.camera = {S(100), S(100), S(31.5), S(31.5), {}};
    point.p_world = Vec<S, 3>(S(0.2), S(-0.1), S(2));
    point.sigma_world = Vec<S, 3>(0, 0, 0);
    point.seen.valid = true;
    point.seen.uv = cast_to<float>(rig.vision.camera.project(point.p_world).uv) + Vec<float, 2>(3, 0);
    point.seen.L << 2, 0.5f, 0, 4;
    point.seen.depth.set({true, S(0.51), S(0.01)});
  }
  Mat<S, 2, 2> L() const { return cast_to<S>(point.seen.L); }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-6;  // an observation is float in both

}  // namespace

TEMPLATE_TEST_CASE("point_in_world: a point without uncertainty is whitened by its pixel and depth alone", "", float,
                   double) {
  using S = TestType;
  const Scene<S> scene;
  const auto pixel = scene.point.pixel_rows(scene.rig, scene.view);
  REQUIRE(pixel.valid);
  CHECK(norm(Vec<S, 2>(pixel.r - scene.L() * Vec<S, 2>(-3, 0))) < 10 * tolerance<S>);
  CHECK(scene.point.error_px(scene.rig, scene.view) == Approx(3).epsilon(tolerance<S>));
  REQUIRE(scene.point.has_depth());
  CHECK(scene.point.depth_rows(scene.view).r[0] == Approx(-1).epsilon(1e-3));  // (0.5 - 0.51)/0.01
}

TEMPLATE_TEST_CASE("point_in_world: an uncertain range widens the noise along the way that it moves the observation",
                   "", float, double) {
  using S = TestType;
  Scene<S> scene;
  scene.point.sigma_world = Vec<S, 3>(S(0.1), 0, S(0.3));
  const auto rows = scene.point.pixel_rows(scene.rig, scene.view);
  const auto certain = Scene<S>().point.pixel_rows(scene.rig, scene.view);
  REQUIRE(rows.valid);
  const Vec<S, 2> moved = scene.rig.vision.camera.project(scene.point.p_world).J_uv_p * scene.point.sigma_world;
  const Mat<S, 2, 2> covariance = (scene.L().transpose() * scene.L()).inverse() + moved * moved.transpose();
  const Vec<S, 2> r = scene.L().inverse() * certain.r;
  CHECK(squared_norm(rows.r) == Approx(r.dot(covariance.inverse() * r)).epsilon(tolerance<S>));
  CHECK(squared_norm(rows.r) < S(0.5) * squared_norm(certain.r));
  const S by_range = S(0.3) / 4;  // d(1/z) by 0.3 m at 2 m
  CHECK(scene.point.depth_rows(scene.view).r[0] == Approx(-0.01 / std::hypot(0.01, double(by_range))).epsilon(1e-3));
}

TEMPLATE_TEST_CASE("point_in_world: behind the camera, or not finite, it has no rows", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const Vec<S, 3>& p : {Vec<S, 3>(0, 0, -2), Vec<S, 3>(0, 0, 0), Vec<S, 3>(0, 0, nan)}) {
    scene.point.p_world = p;
    CHECK_FALSE(scene.point.pixel_rows(scene.rig, scene.view).valid);
    CHECK(scene.point.error_px(scene.rig, scene.view) == 0);
    CHECK_FALSE(scene.point.depth_rows(scene.view).valid);
  }
  scene.point.seen.depth.set({});
  CHECK_FALSE(scene.point.has_depth());
  STATIC_REQUIRE(sizeof(PointInWorld<Rig<Mono<Pinhole<S>, 64 * 64>>>) <
                 sizeof(scene.point));  // a camera alone has none
}
