#include "plumbline/feature/line_in_world.hpp"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <type_traits>

#include "catch.hpp"
#include "feature/seen_lines.hpp"
#include "plumbline/camera/pinhole.hpp"

using namespace plumbline;

namespace {

/// The line through two points before a camera that is its body, seen 2 px above where it is.
template <class S>
struct Scene {
  using Seen = SegmentObservation<S, true, false>;
  LineInWorld<Seen> line;
  BodyView<S> view{SE3<S>(), SE3<S>()};

  Scene() {
    const Pinhole<double> camera{100, 100, 31.5, 31.5, {}};
    const Vec<double, 3> p(-0.4, 0.1, 2), q(0.4, 0.1, 2), up(0, -0.04, 0);
    testing::Gaussian noise(1);
    line.line = Line3<double>::through(p, q).template cast<S>().plucker();
    line.covariance = zeros<S, 6, 6>();
    line.seen = test::observe_segment<Seen>(camera, p + up, q + up, 0, noise);
    REQUIRE(line.seen.valid);
  }
};

template <class S>
constexpr double tolerance = std::is_same_v<S, float> ? 1e-3 : 1e-9;

}  // namespace

TEMPLATE_TEST_CASE("line_in_world: a line without uncertainty is whitened by its segment and depth alone", "", float,
                   double) {
  using S = TestType;
  const Scene<S> scene;
  CHECK(scene.line.error_px(scene.view) == Approx(2).epsilon(0.01));
  const auto pixels = scene.line.pixel_rows(scene.view);
  REQUIRE(pixels.valid);
  const auto& seen = scene.line.seen.pixels;
  const Vec<S, 2> r = seen.measured.residual(scene.line.line);
  CHECK(squared_norm(pixels.r) == Approx(r.dot(seen.covariance.inverse() * r)).epsilon(tolerance<S>));
  const auto depth = scene.line.depth_rows(scene.view);
  REQUIRE(depth.valid);
  CHECK(norm(depth.r) < 1);  // the depth is right
}

TEMPLATE_TEST_CASE("line_in_world: the covariance of the line is added to that of the segment", "", float, double) {
  using S = TestType;
  Scene<S> scene;
  for (int k = 0; k < 6; ++k) scene.line.covariance(k, k) = S(1e-4 * (k + 1));
  const auto rows = scene.line.pixel_rows(scene.view);
  REQUIRE(rows.valid);
  const auto& seen = scene.line.seen.pixels;
  const auto lin = seen.measured.linearize(scene.line.line);
  Mat<S, 2, 6> J;  // by (n; v), the camera being at the origin
  J << lin.J_r_n, lin.J_r_v;
  const Mat<S, 2, 2> covariance = seen.covariance + J * scene.line.covariance * J.transpose();
  CHECK(squared_norm(rows.r) == Approx(lin.r.dot(covariance.inverse() * lin.r)).epsilon(tolerance<S>));
  CHECK(squared_norm(rows.r) < S(0.9) * squared_norm(Scene<S>().line.pixel_rows(scene.view).r));
}

TEMPLATE_TEST_CASE("line_in_world: where it is not visible, or its covariance is none, it has no rows", "", float,
                   double) {
  using S = TestType;
  Scene<S> scene;
  const S nan = std::numeric_limits<S>::quiet_NaN();
  for (const S bad : {nan, S(-1e3)}) {
    scene.line.covariance = bad * identity<S, 6>();
    CHECK_FALSE(scene.line.pixel_rows(scene.view).valid);
    CHECK_FALSE(scene.line.depth_rows(scene.view).valid);
  }
  scene.line.covariance = zeros<S, 6, 6>();
  const BodyView<S> away(SE3<S>(SO3<S>::exp({S(0), S(3.14159), S(0)}), {0, 0, 0}), SE3<S>());
  CHECK_FALSE(scene.line.pixel_rows(away).valid);
  CHECK_FALSE(scene.line.depth_rows(away).valid);
}
