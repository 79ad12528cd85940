#include "plumbline/residual/relative_view.hpp"

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/points.hpp"

using namespace plumbline;
using test::PointScene;

TEST_CASE("relative_view: scaled point is lambda times the point in the target camera") {
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    const PointScene s(seed);
    if (s.lambda == 0) continue;
    const RelativeView<double> view(s.T_world_anchor, s.T_world_target, s.T_body_cam);
    const Vec<double, 3> p_anchor_cam = s.bearing / s.lambda;
    const SE3<double> T_target_anchor = (s.T_world_target * s.T_body_cam).inverse() * (s.T_world_anchor * s.T_body_cam);
    REQUIRE((view.scaled_point(s.bearing, s.lambda) - s.lambda * (T_target_anchor * p_anchor_cam)).norm() < 1e-12);
    REQUIRE((view.t_target_anchor() - T_target_anchor.p()).norm() < 1e-12);
    REQUIRE((view.R_target_anchor() - T_target_anchor.R()).norm() < 1e-12);
  }
}

TEMPLATE_TEST_CASE("relative_view: Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-5 : 1e-9;
  for (std::uint64_t seed = 1; seed < 50; ++seed) {
    const PointScene s(seed);
    const RelativeView<S> view(s.T_world_anchor.cast<S>(), s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
    const ScaledPoint<S> point = view.linearize(s.bearing.cast<S>(), S(s.lambda));
    const auto at = [&](const SE3<double>& T_a, const SE3<double>& T_j, double lambda) -> Vec<double, 3> {
      return RelativeView<double>(T_a, T_j, s.T_body_cam).scaled_point(s.bearing, lambda);
    };
    using testing::jacobian_error;
    REQUIRE(jacobian_error(
                point.J_anchor, [&](const SE3<double>& T) { return at(T, s.T_world_target, s.lambda); },
                s.T_world_anchor) < tolerance);
    REQUIRE(jacobian_error(
                point.J_target, [&](const SE3<double>& T) { return at(s.T_world_anchor, T, s.lambda); },
                s.T_world_target) < tolerance);
    const Mat<double, 6, 6> M = (s.T_world_target.inverse() * s.T_world_anchor).adjoint();
    REQUIRE((point.J_anchor.template cast<double>() + point.J_target.template cast<double>() * M).norm() <
            tolerance * M.norm());  // (4a)
    const Mat<S, 2, 3> by_P = (Mat<S, 2, 3>() << 1, -2, 3, 0.5, 4, -1).finished();
    REQUIRE((view.template target_jacobian<2>(by_P, point.P, S(s.lambda)) - by_P * point.J_target).norm() <
            tolerance * point.J_target.norm());
    REQUIRE(jacobian_error(
                view.t_target_anchor(),
                [&](const Vec<double, 1>& x) { return at(s.T_world_anchor, s.T_world_target, x(0)); },
                Vec<double, 1>(s.lambda)) < tolerance);
  }
}
