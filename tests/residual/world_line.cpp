#include "plumbline/residual/world_line.hpp"

#include "catch.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"
#include "residual/lines.hpp"

using namespace plumbline;
using test::LineScene;
using testing::jacobian_error;

namespace {

template <class S, class Measurement>
void check(const LineScene& s, const Measurement& measured, double tolerance) {
  const Plucker<double> line = (s.T_world_anchor * s.T_body_cam) * s.line.plucker();
  const BodyView<S> view(s.T_world_target.cast<S>(), s.T_body_cam.cast<S>());
  const auto cast = test::cast<S>(measured);
  const auto lin = WorldLine<decltype(cast)>{cast}.linearize(view, {line.n.cast<S>(), line.v.cast<S>()});
  REQUIRE(lin.valid);
  const auto r = [&](const SE3<double>& T, const Plucker<double>& x) -> Vec<double, 2> {
    return measured.residual((T * s.T_body_cam).inverse() * x);
  };
  REQUIRE((lin.r.template cast<double>() - r(s.T_world_target, line)).norm() < tolerance * (1 + lin.r.norm()));
  REQUIRE(jacobian_error(
              lin.J_r_pose, [&](const SE3<double>& T) { return r(T, line); }, s.T_world_target, 1e-5) < tolerance);
  Vec<double, 6> nv;
  nv << line.n, line.v;
  REQUIRE(jacobian_error(
              lin.J_r_line,
              [&](const Vec<double, 6>& x) {
                return r(s.T_world_target, {x.head<3>(), x.tail<3>()});
              },
              nv, 1e-5) < tolerance);
}

}  // namespace

TEMPLATE_TEST_CASE("world_line: Jacobians by the pose and the line", "", float, double) {
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

TEST_CASE("world_line: behind the camera is not valid") {
  const BodyView<double> view{SE3<double>(), SE3<double>()};
  const LineReprojection<double> seen{Vec<double, 3>::UnitZ(), Vec<double, 3>(0.1, 0, 1).normalized(), {400, 400}};
  REQUIRE(WorldLine<LineReprojection<double>>{seen}
              .linearize(view, Line3<double>::through({0, 0.1, 2}, {1, 0.1, 2}).plucker())
              .valid);
  REQUIRE_FALSE(WorldLine<LineReprojection<double>>{seen}
                    .linearize(view, Line3<double>::through({0, 0.1, -2}, {1, 0.1, -2}).plucker())
                    .valid);
}
