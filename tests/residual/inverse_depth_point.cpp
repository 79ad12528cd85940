#include "plumbline/residual/inverse_depth_point.hpp"

#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/points.hpp"

using namespace plumbline;
using test::PointScene;
using testing::jacobian_error;

namespace {

template <class S>
Pinhole<S> camera_of(const PointScene& s) {
  return {S(s.camera.fx), S(s.camera.fy), S(s.camera.cx), S(s.camera.cy), {}};
}

/// Checks the three Jacobians of a linearization against differences of `value(T_anchor, T_target, lambda)`.
template <class Linearized, class Value>
void check_jacobians(const PointScene& s, const Linearized& lin, Value&& value, double tolerance) {
  REQUIRE(jacobian_error(
              lin.J_r_anchor, [&](const SE3<double>& T) { return value(T, s.T_world_target, s.lambda); },
              s.T_world_anchor) < tolerance);
  REQUIRE(jacobian_error(
              lin.J_r_target, [&](const SE3<double>& T) { return value(s.T_world_anchor, T, s.lambda); },
              s.T_world_target) < tolerance);
  REQUIRE(jacobian_error(
              lin.J_r_lambda, [&](const Vec<double, 1>& x) { return value(s.T_world_anchor, s.T_world_target, x(0)); },
              Vec<double, 1>(s.lambda)) < tolerance);
}

}  // namespace

TEMPLATE_TEST_CASE("inverse_depth_point: Jacobians of reprojection and of measured inverse depth", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-7;
  int checked = 0;
  for (std::uint64_t seed = 1; seed < 80; ++seed) {
    const PointScene s(seed);
    const RelativeView<S> view(s.T_world_anchor.cast<S>(), s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
    const InverseDepthReprojection<Pinhole<S>> reprojection{Vec<S, 2>(S(300), S(200))};
    const InverseDepthMeasurement<S> depth{S(0.4)};
    const auto lin_uv = reprojection.linearize(camera_of<S>(s), view, s.bearing.cast<S>(), S(s.lambda));
    const auto lin_z = depth.linearize(view, s.bearing.cast<S>(), S(s.lambda));
    if (!lin_uv.valid) continue;
    REQUIRE(lin_z.valid);
    ++checked;
    check_jacobians(
        s, lin_uv,
        [&](const SE3<double>& T_a, const SE3<double>& T_j, double lambda) -> Vec<double, 2> {
          const RelativeView<double> v(T_a, T_j, s.T_body_cam);
          return InverseDepthReprojection<Pinhole<double>>{{300, 200}}.linearize(s.camera, v, s.bearing, lambda).r;
        },
        tolerance);
    check_jacobians(
        s, lin_z,
        [&](const SE3<double>& T_a, const SE3<double>& T_j, double lambda) -> Vec<double, 1> {
          const RelativeView<double> v(T_a, T_j, s.T_body_cam);
          return InverseDepthMeasurement<double>{0.4}.linearize(v, s.bearing, lambda).r;
        },
        tolerance);
  }
  REQUIRE(checked > 40);
}

TEMPLATE_TEST_CASE("inverse_depth_point: the same by the scaled point alone, and chained", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-7;
  int checked = 0;
  for (std::uint64_t seed = 1; seed < 80; ++seed) {
    const PointScene s(seed);
    const RelativeView<S> view(s.T_world_anchor.cast<S>(), s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
    const Vec<S, 3> f = s.bearing.cast<S>(), P = view.scaled_point(f, S(s.lambda));
    const InverseDepthReprojection<Pinhole<S>> reprojection{Vec<S, 2>(S(300), S(200))};
    const InverseDepthMeasurement<S> depth{S(0.4)};
    const auto uv = reprojection.linearize(camera_of<S>(s), P);
    if (!uv.valid || P.z() < S(0.1)) continue;
    const auto z = depth.linearize(P, S(s.lambda));
    REQUIRE(z.valid);
    ++checked;
    const Vec<double, 3> P_d = P.template cast<double>();
    const auto uv_of = [&](const Vec<double, 3>& x) -> Vec<double, 2> {
      return InverseDepthReprojection<Pinhole<double>>{{300, 200}}.linearize(s.camera, x).r;
    };
    const auto z_of = [&](const Vec<double, 3>& x, double lambda) -> Vec<double, 1> {
      return InverseDepthMeasurement<double>{0.4}.linearize(x, lambda).r;
    };
    REQUIRE((uv.r.template cast<double>() - uv_of(P_d)).norm() < 1e3 * tolerance);
    REQUIRE(std::abs(double(z.r(0)) - z_of(P_d, s.lambda)(0)) < tolerance);
    REQUIRE(jacobian_error(uv.J_r_P, uv_of, P_d) < tolerance);
    REQUIRE(jacobian_error(
                z.J_r_P, [&](const Vec<double, 3>& x) { return z_of(x, s.lambda); }, P_d) < tolerance);
    REQUIRE(jacobian_error(
                z.J_r_lambda, [&](const Vec<double, 1>& x) { return z_of(P_d, x(0)); }, Vec<double, 1>(s.lambda)) <
            tolerance);

    // Chained by (2)-(4) they are the residual's own.
    const auto chained_uv = reprojection.linearize(camera_of<S>(s), view, f, S(s.lambda));
    const auto chained_z = depth.linearize(view, f, S(s.lambda));
    const ScaledPoint<S> point = view.linearize(f, S(s.lambda));
    REQUIRE(chained_uv.r == uv.r);
    REQUIRE(chained_z.r == z.r);
    const auto same = [&](const auto& a, const auto& b) {
      return double((a - b).norm()) <= tolerance * (1 + double(b.norm()));
    };
    REQUIRE(same(chained_uv.J_r_anchor, (uv.J_r_P * point.J_anchor).eval()));
    REQUIRE(same(chained_uv.J_r_target, view.template target_jacobian<2>(uv.J_r_P, P, S(s.lambda))));
    REQUIRE(same(chained_uv.J_r_lambda, (uv.J_r_P * view.t_target_anchor()).eval()));
    REQUIRE(same(chained_z.J_r_target, view.template target_jacobian<1>(z.J_r_P, P, S(s.lambda))));
    REQUIRE(same(chained_z.J_r_lambda, (z.J_r_lambda + z.J_r_P * view.t_target_anchor()).eval()));
  }
  REQUIRE(checked > 40);
}

TEST_CASE("inverse_depth_point: invalid behind the camera and for NaN") {
  const Pinhole<double> camera{458, 457, 367, 248, {}};
  const SE3<double> I;
  const RelativeView<double> turned(I, SE3<double>(SO3<double>::exp({0, 3.1, 0}), Vec<double, 3>::Zero()), I);
  const InverseDepthReprojection<Pinhole<double>> residual{{0, 0}};
  REQUIRE_FALSE(residual.linearize(camera, turned, Vec<double, 3>::UnitZ(), 0.5).valid);
  REQUIRE_FALSE(InverseDepthMeasurement<double>{1}.linearize(turned, Vec<double, 3>::UnitZ(), 0.5).valid);
  REQUIRE_FALSE(residual.linearize(camera, Vec<double, 3>(0, 0, -1)).valid);
  REQUIRE_FALSE(InverseDepthMeasurement<double>{1}.linearize(Vec<double, 3>(0, 0, -1), 0.5).valid);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(residual.linearize(camera, Vec<double, 3>(0, 0, nan)).valid);
  REQUIRE_FALSE(InverseDepthMeasurement<double>{1}.linearize(Vec<double, 3>(0, 0, nan), 0.5).valid);
  const RelativeView<double> same(I, I, I);
  REQUIRE_FALSE(residual.linearize(camera, same, Vec<double, 3>(0, 0, nan), 0.5).valid);
}

TEST_CASE("inverse_depth_point: the anchor's own view has no baseline") {
  const SE3<double> T(SO3<double>::exp({0.1, 0.2, 0.3}), Vec<double, 3>(1, 2, 3));
  const RelativeView<double> view(T, T, SE3<double>(SO3<double>::exp({1, 0, 0}), Vec<double, 3>(0.1, 0, 0)));
  REQUIRE(view.t_target_anchor().norm() < 1e-12);
  const Vec<double, 3> f = Vec<double, 3>(0.1, -0.2, 1).normalized();
  REQUIRE((view.scaled_point(f, 0.5) - f).norm() < 1e-12);
}
