#include "plumbline/residual/world_point.hpp"

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/points.hpp"

using namespace plumbline;
using test::PointScene;
using testing::jacobian_error;

TEMPLATE_TEST_CASE("world_point: Jacobians of reprojection and inverse depth", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-7;
  for (std::uint64_t seed = 1; seed < 60; ++seed) {
    const PointScene s(seed);
    const Vec<double, 3> p_world =
        s.T_world_target * (s.T_body_cam * Vec<double, 3>(s.bearing * (1 + double(seed % 5))));
    const BodyView<S> view(s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
    const Pinhole<S> camera{S(s.camera.fx), S(s.camera.fy), S(s.camera.cx), S(s.camera.cy), {}};
    const auto lin_uv = PointReprojection<Pinhole<S>>{{S(300), S(200)}}.linearize(camera, view, p_world.cast<S>());
    const auto lin_z = PointInverseDepth<S>{S(0.4)}.linearize(view, p_world.cast<S>());
    REQUIRE(lin_uv.valid);
    REQUIRE(lin_z.valid);
    const auto uv = [&](const SE3<double>& T, const Vec<double, 3>& X) -> Vec<double, 2> {
      return PointReprojection<Pinhole<double>>{{300, 200}}.linearize(s.camera, {T, s.T_body_cam}, X).r;
    };
    const auto iz = [&](const SE3<double>& T, const Vec<double, 3>& X) -> Vec<double, 1> {
      return PointInverseDepth<double>{0.4}.linearize({T, s.T_body_cam}, X).r;
    };
    REQUIRE(jacobian_error(
                lin_uv.J_r_pose, [&](const SE3<double>& T) { return uv(T, p_world); }, s.T_world_target) < tolerance);
    REQUIRE(jacobian_error(
                lin_uv.J_r_point, [&](const Vec<double, 3>& X) { return uv(s.T_world_target, X); }, p_world) <
            tolerance);
    REQUIRE(jacobian_error(
                lin_z.J_r_pose, [&](const SE3<double>& T) { return iz(T, p_world); }, s.T_world_target) < tolerance);
    REQUIRE(jacobian_error(
                lin_z.J_r_point, [&](const Vec<double, 3>& X) { return iz(s.T_world_target, X); }, p_world) <
            tolerance);
  }
}

TEST_CASE("world_point: invalid behind the camera") {
  const BodyView<double> view{SE3<double>(), SE3<double>()};
  const Pinhole<double> camera{400, 400, 320, 240, {}};
  REQUIRE_FALSE(PointReprojection<Pinhole<double>>{{0, 0}}.linearize(camera, view, {0, 0, -1}).valid);
  REQUIRE_FALSE(PointInverseDepth<double>{1}.linearize(view, {0, 0, -1}).valid);
}
