#include "plumbline/frontend/visible_segment.hpp"

#include <limits>
#include <memory>

#include "catch.hpp"
#include "plumbline/camera/pinhole.hpp"
#include "plumbline/camera/radtan.hpp"
#include "plumbline/sensor/mono.hpp"

using namespace plumbline;

namespace {

template <class Camera, class Shutter = Global>
struct Scene {
  using S = typename Camera::Scalar;
  using Sensors = Rig<Mono<Camera, 320 * 240, Shutter>>;
  Sensors rig{};
  std::unique_ptr<RigPyramid<Sensors>> pyramid = std::make_unique<RigPyramid<Sensors>>();
  std::array<std::uint8_t, 320 * 240> pixels{};

  explicit Scene(const Camera& camera) {
    rig.vision.camera = camera;
    REQUIRE(pyramid->build({pixels.data(), 320, 240, 320}));
  }
  bool see(const Vec<S, 3>& p, const Vec<S, 3>& q, LineSegment& out, S readout_s = 0,
           const Vec<S, 3>& rate = Vec<S, 3>::Zero(), const Vec<S, 3>& velocity = Vec<S, 3>::Zero()) const {
    View<Sensors> view{0, S(0), rig, *pyramid, *pyramid, {}, {}, {}, {rig.vision.camera, 240, readout_s}};
    view.shutter.set_motion(rate, velocity, 0);
    return visible_segment(view, p, q, out);
  }
};

}  // namespace

TEMPLATE_TEST_CASE("visible_segment: whole, cut, behind, outside", "", float, double) {
  using S = TestType;
  using V = Vec<S, 3>;
  const Scene<Pinhole<S>> scene({S(200), S(200), S(159.5), S(119.5), {}});
  LineSegment out;
  REQUIRE(scene.see(V(S(-0.5), S(0.1), S(2)), V(S(0.5), S(0.2), S(2)), out));
  REQUIRE((out.start - Vec<float, 2>(109.5f, 129.5f)).norm() < 1e-3f);
  REQUIRE((out.end - Vec<float, 2>(209.5f, 139.5f)).norm() < 1e-3f);
  REQUIRE(scene.see(V(-20, 0, 2), V(S(0.5), 0, 2), out));  // cut at a sixteenth
  REQUIRE(out.start.x() >= 4);
  REQUIRE(out.start.x() < 320);
  REQUIRE((out.end - Vec<float, 2>(209.5f, 119.5f)).norm() < 1e-3f);
  REQUIRE(scene.see(V(S(0.1), 0, -2), V(S(0.1), S(0.1), 4), out));  // comes from behind the camera
  REQUIRE(scene.rig.vision.camera.project(V(S(0.1), 0, -2)).valid == false);
  REQUIRE_FALSE(scene.see(V(0, 0, -2), V(1, 0, -1), out));
  REQUIRE_FALSE(scene.see(V(10, 0, 2), V(10, 1, 2), out));
  const S nan = std::numeric_limits<S>::quiet_NaN();
  REQUIRE_FALSE(scene.see(V(nan, 0, 2), V(1, 0, 2), out));
}

TEST_CASE("visible_segment: a distorted image, read row by row") {
  using V = Vec<double, 3>;
  const Pinhole<double, RadTan> camera{200, 200, 159.5, 119.5, {-0.28, 0.07, 0, 0}};
  const Scene<Pinhole<double, RadTan>, Rolling> scene(camera);
  LineSegment out;
  const V p(-0.7, 0.4, 2), q(0.6, 0.5, 2), rate(0, 1, 0), velocity(2, 0, 0);
  REQUIRE(scene.see(p, q, out));
  REQUIRE((out.start - camera.project(p).uv.cast<float>()).norm() < 1e-3f);
  REQUIRE(scene.see(p, q, out, 0.02, rate));
  RollingShutter<Pinhole<double, RadTan>> shutter(camera, 240, 0.02);
  shutter.set_motion(rate, V::Zero(), 0);
  REQUIRE((out.start - shutter.seen(camera.project(p).uv, 0).cast<float>()).norm() < 1e-3f);
  REQUIRE((out.start - camera.project(p).uv.cast<float>()).norm() > 0.5f);
  shutter.set_motion(rate, velocity, 0);
  REQUIRE(scene.see(p, q, out, 0.02, rate, velocity));
  REQUIRE((out.start - shutter.seen(camera.project(p).uv, 1 / p.norm()).cast<float>()).norm() < 1e-3f);
  REQUIRE((out.start - shutter.seen(camera.project(p).uv, 0).cast<float>()).norm() > 0.2f);

  const Scene<Pinhole<double, RadTan>, Global> global(camera);  // all rows at once, whatever the readout time
  REQUIRE(global.see(p, q, out, 0.02, rate));
  REQUIRE((out.start - camera.project(p).uv.cast<float>()).norm() < 1e-3f);
}
