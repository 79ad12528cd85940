#include "plumbline/residual/collinear_point.hpp"

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/lines.hpp"

using namespace plumbline;
using test::LineScene;
using testing::jacobian_error;

namespace {

/// A point beside the line of a scene, as the camera of another body holds it.
struct PointScene : LineScene {
  SE3<double> T_world_point;  ///< of the body whose camera holds the point
  Vec<double, 3> bearing;
  double lambda;

  explicit PointScene(std::uint64_t seed, Kind kind = ordinary, double beside = 0.05)
      : LineScene(seed, kind), T_world_point(T_world_target) {
    Random random(seed + 1000);
    const auto uniform = [&](double low, double high) { return low + (high - low) * random.uniform(); };
    const Vec<double, 3> off{uniform(-beside, beside), uniform(-beside, beside), uniform(-beside, beside)};
    const Vec<double, 3> on_line = line.closest_point() + uniform(-0.5, 0.5) * line.direction();
    const SE3<double> T_point_line = (T_world_point * T_body_cam).inverse() * (T_world_anchor * T_body_cam);
    const Vec<double, 3> X = T_point_line * Vec<double, 3>(on_line + off);
    bearing = X.normalized();
    lambda = 1 / X.norm();
  }

  Vec<double, 2> residual(const SE3<double>& T_point, const SE3<double>& T_line, const Line3<double>& l,
                          double inverse_range) const {
    const RelativeView<double> view(T_point, T_line, T_body_cam);
    return CollinearPoint<double>::residual(l, view.scaled_point(bearing, inverse_range), inverse_range);
  }
};

}  // namespace

TEMPLATE_TEST_CASE("collinear_point: Jacobians by the line's pose, the point and the line", "", float, double) {
  using S = TestType;
  for (const auto kind : {LineScene::ordinary, LineScene::near_center, LineScene::along_view}) {
    const double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-7;
    for (std::uint64_t seed = 1; seed < 60; ++seed) {
      const PointScene s(seed, kind);
      const RelativeView<S> view(s.T_world_point.cast<S>(), s.T_world_anchor.cast<S>(), s.T_body_cam.cast<S>());
      const auto lin = CollinearPoint<S>::linearize(view, s.line.cast<S>(), s.bearing.cast<S>(), S(s.lambda));
      const Vec<double, 2> r = s.residual(s.T_world_point, s.T_world_anchor, s.line, s.lambda);
      REQUIRE((lin.r.template cast<double>() - r).norm() < tolerance * (1 + r.norm()));
      REQUIRE(jacobian_error(
                  lin.J_r_target,
                  [&](const SE3<double>& T) { return s.residual(s.T_world_point, T, s.line, s.lambda); },
                  s.T_world_anchor, 1e-5) < tolerance);
      REQUIRE(jacobian_error(
                  lin.J_r_line,
                  [&](const Line3<double>& x) { return s.residual(s.T_world_point, s.T_world_anchor, x, s.lambda); },
                  s.line, 1e-5) < tolerance);
      REQUIRE(jacobian_error(
                  Mat<S, 2, 1>(lin.J_r_lambda),
                  [&](const Vec<double, 1>& x) { return s.residual(s.T_world_point, s.T_world_anchor, s.line, x[0]); },
                  Vec<double, 1>(s.lambda), 1e-5) < tolerance);
      // The pose of the point's body follows from that of the line's.
      const Mat<double, 6, 6> transport = (s.T_world_anchor.inverse() * s.T_world_point).adjoint();
      REQUIRE(jacobian_error(
                  Mat<double, 2, 6>(-lin.J_r_target.template cast<double>() * transport),
                  [&](const SE3<double>& T) { return s.residual(T, s.T_world_anchor, s.line, s.lambda); },
                  s.T_world_point, 1e-5) < 10 * tolerance);
    }
  }
}

TEMPLATE_TEST_CASE("collinear_point: Jacobians in the line's own camera", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-7;
  for (std::uint64_t seed = 1; seed < 60; ++seed) {
    PointScene s(seed);
    s.bearing = (s.line.closest_point() + 0.3 * s.line.direction() + Vec<double, 3>(0.01, 0.02, -0.01)).normalized();
    const auto lin = CollinearPoint<S>::linearize(s.line.cast<S>(), s.bearing.cast<S>(), S(s.lambda));
    const auto r = [&](const Line3<double>& line, double lambda) {
      return CollinearPoint<double>::residual(line, s.bearing, lambda);
    };
    REQUIRE(lin.J_r_target.isZero(S(0)));
    REQUIRE(jacobian_error(
                lin.J_r_line, [&](const Line3<double>& x) { return r(x, s.lambda); }, s.line, 1e-5) < tolerance);
    REQUIRE(jacobian_error(
                Mat<S, 2, 1>(lin.J_r_lambda), [&](const Vec<double, 1>& x) { return r(s.line, x[0]); },
                Vec<double, 1>(s.lambda), 1e-5) < tolerance);
  }
}

TEST_CASE("collinear_point: the length is the distance by the range, whatever the scale") {
  for (std::uint64_t seed = 1; seed < 60; ++seed) {
    const PointScene s(seed);
    const Vec<double, 3> X = ((s.T_world_anchor * s.T_body_cam).inverse() * (s.T_world_point * s.T_body_cam)) *
                             Vec<double, 3>(s.bearing / s.lambda);
    const Vec<double, 3> off = X - s.line.closest_point();
    const double distance = off.cross(s.line.direction()).norm();
    const Vec<double, 2> r = s.residual(s.T_world_point, s.T_world_anchor, s.line, s.lambda);
    REQUIRE(r.norm() == Approx(s.lambda * distance).epsilon(1e-9).margin(1e-12));
    const double scale = 3;
    const auto scaled = [&](const SE3<double>& T) { return SE3<double>(T.rotation(), scale * T.p()); };
    const Plucker<double> line = s.line.plucker();
    const RelativeView<double> view(scaled(s.T_world_point), scaled(s.T_world_anchor), scaled(s.T_body_cam));
    const Line3<double> longer(Plucker<double>{scale * line.n, line.v});
    const double lambda = s.lambda / scale;
    REQUIRE((CollinearPoint<double>::residual(longer, view.scaled_point(s.bearing, lambda), lambda) - r).norm() <
            1e-12);
  }
}
