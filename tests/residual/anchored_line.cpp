#include "plumbline/residual/anchored_line.hpp"

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/lines.hpp"

using namespace plumbline;
using test::LineScene;
using testing::jacobian_error;

namespace {

template <class S, class Measurement>
void check(const LineScene& s, const Measurement& measured, double tolerance) {
  const RelativeView<S> view(s.T_world_anchor.cast<S>(), s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
  const auto cast = test::cast<S>(measured);
  const auto lin = AnchoredLine<decltype(cast)>{cast}.linearize(view, s.line.template cast<S>());
  REQUIRE(lin.valid);
  const auto r = [&](const SE3<double>& T_a, const SE3<double>& T_j, const Line3<double>& line) -> Vec<double, 2> {
    return measured.residual(line_in_target(RelativeView<double>(T_a, T_j, s.T_body_cam), line.plucker()));
  };
  const double step = 1e-5;
  REQUIRE((lin.r.template cast<double>() - r(s.T_world_anchor, s.T_world_target, s.line)).norm() <
          tolerance * (1 + lin.r.norm()));
  REQUIRE(jacobian_error(
              lin.J_r_anchor, [&](const SE3<double>& T) { return r(T, s.T_world_target, s.line); }, s.T_world_anchor,
              step) < tolerance);
  REQUIRE(jacobian_error(
              lin.J_r_target, [&](const SE3<double>& T) { return r(s.T_world_anchor, T, s.line); }, s.T_world_target,
              step) < tolerance);
  REQUIRE(jacobian_error(
              lin.J_r_lambda, [&](const Line3<double>& x) { return r(s.T_world_anchor, s.T_world_target, x); }, s.line,
              step) < tolerance);
}

}  // namespace

TEMPLATE_TEST_CASE("anchored_line: Jacobians by both poses and the line", "", float, double) {
  using S = TestType;
  for (const auto kind : {LineScene::ordinary, LineScene::near_center, LineScene::along_view}) {
    const double tolerance = !std::is_same_v<S, float> ? 1e-7 : kind == LineScene::ordinary ? 2e-4 : 2e-3;
    for (std::uint64_t seed = 1; seed < 60; ++seed) {
      const LineScene s(seed, kind);
      check<S>(s, s.pixels, tolerance);
      check<S>(s, s.depth, tolerance);
    }
  }
}

TEMPLATE_TEST_CASE("anchored_line: the anchor's own measurement depends on the line alone", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-7;
  for (std::uint64_t seed = 1; seed < 60; ++seed) {
    const LineScene s(seed);
    const SE3<double> T = (s.T_world_target * s.T_body_cam).inverse() * (s.T_world_anchor * s.T_body_cam);
    const Line3<double> line = T * s.line;  // the camera that measured is the anchor now
    const auto lin = AnchoredLineReprojection<S>{test::cast<S>(s.pixels)}.linearize_in_anchor(line.template cast<S>());
    REQUIRE(lin.valid);
    REQUIRE(jacobian_error(
                lin.J_r_line, [&](const Line3<double>& x) { return s.pixels.residual(x.plucker()); }, line, 1e-5) <
            tolerance);
    const auto lin_z = AnchoredLineInverseDepth<S>{test::cast<S>(s.depth)}.linearize_in_anchor(line.template cast<S>());
    REQUIRE(lin_z.valid);
    REQUIRE(jacobian_error(
                lin_z.J_r_line, [&](const Line3<double>& x) { return s.depth.residual(x.plucker()); }, line, 1e-5) <
            tolerance);
    // the same through a view of the anchor on itself
    const RelativeView<S> same(s.T_world_target.cast<S>(), s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
    const auto viewed = AnchoredLineReprojection<S>{test::cast<S>(s.pixels)}.linearize(same, line.template cast<S>());
    REQUIRE((viewed.J_r_lambda - lin.J_r_line).norm() < S(1e-3) * lin.J_r_line.norm());
    REQUIRE((viewed.J_r_anchor + viewed.J_r_target).norm() < S(1e-3) * viewed.J_r_anchor.norm());
  }
}

TEST_CASE("anchored_line: a line through the target's center is not valid there") {
  const LineScene s(1);
  const SE3<double> I;
  const Line3<double> line = Line3<double>::through({1, 0, 2}, {1, 0, 3});
  const RelativeView<double> inside(I, SE3<double>(SO3<double>(), {1, 0, 0}), I);
  REQUIRE_FALSE(AnchoredLineReprojection<double>{s.pixels}.linearize(inside, line).valid);
}
