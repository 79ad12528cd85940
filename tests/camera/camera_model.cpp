#include "plumbline/camera/camera_model.hpp"

#include "catch.hpp"
#include "plumbline/camera/double_sphere.hpp"
#include "plumbline/camera/equidistant.hpp"
#include "plumbline/camera/pinhole.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("camera_model: effective focal length is the smaller one on the axis", "", float, double) {
  using S = TestType;
  CHECK(double(effective_focal_length(Pinhole<S>{500, 420, 320, 240})) == Approx(420));
  CHECK(double(effective_focal_length(Equidistant<S>(190, 200, 256, 256, S(0.1)))) == Approx(190));
  // Double sphere on the axis: N = alpha |xi + 1| + (1 - alpha)(xi + 1) = xi + 1 for a point at distance 1.
  CHECK(double(effective_focal_length(DoubleSphere<S>(200, 210, 0, 0, S(0.25), S(0.6)))) == Approx(160));
}

TEMPLATE_TEST_CASE("camera_model: the bearing Jacobian is a right inverse, tangent to the sphere", "", float, double) {
  using S = TestType;
  const Equidistant<S> camera(190, 191, 256, 257, S(-0.02), S(0.003));
  for (S u = 40; u < 500; u += 35) {
    const Unprojection<S> ray = camera.unproject({u, S(300)});
    REQUIRE(ray.valid);
    const Mat<S, 2, 3> J = camera.project(ray.bearing).J_uv_p;
    const Mat<S, 3, 2> J_bearing = bearing_jacobian<S>(J);
    const S tolerance = std::is_same_v<S, float> ? S(1e-4) : S(1e-12);
    CHECK((J * J_bearing - Mat<S, 2, 2>::Identity()).norm() < tolerance);
    CHECK((ray.bearing.transpose() * J_bearing).norm() < tolerance / S(100));
  }
}
