#include "plumbline/geometry/line3.hpp"

#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

template <class S>
Vec<S, 3> random_vector(Random& random, double size) {
  const double x = random.uniform(), y = random.uniform(), z = random.uniform();
  return (size * Vec<double, 3>(2 * x - 1, 2 * y - 1, 2 * z - 1)).cast<S>();
}

template <class S>
SE3<S> random_pose(Random& random) {
  const Vec<S, 3> phi = random_vector<S>(random, 2);
  return {SO3<S>::exp(phi), random_vector<S>(random, 3)};
}

/// Distance of a point to the line.
template <class S>
S distance(const Line3<S>& line, const Vec<S, 3>& p) {
  return (p - line.closest_point()).cross(line.direction()).norm();
}

template <class S>
constexpr S tolerance = std::is_same_v<S, float> ? S(2e-5) : S(1e-12);

}  // namespace

TEMPLATE_TEST_CASE("line3: goes through its points, in every frame", "", float, double) {
  using S = TestType;
  Random random(1);
  for (int i = 0; i < 100; ++i) {
    const Vec<S, 3> p = random_vector<S>(random, 3), q = random_vector<S>(random, 3);
    const Line3<S> line = Line3<S>::through(p, q);
    REQUIRE(distance(line, p) < tolerance<S>);
    REQUIRE(distance(line, q) < tolerance<S>);
    REQUIRE((line.direction() - (q - p).normalized()).norm() < tolerance<S>);
    REQUIRE(std::abs(line.closest_point().dot(line.direction())) < tolerance<S>);
    REQUIRE(line.closest_point().norm() == Approx(line.distance()).margin(tolerance<S>));
    const SE3<S> T = random_pose<S>(random);
    const Line3<S> moved = T * line;
    REQUIRE(distance(moved, T * p) < 5 * tolerance<S>);
    REQUIRE(distance(moved, T * q) < 5 * tolerance<S>);
    REQUIRE((moved.direction() - T.rotation() * line.direction()).norm() < tolerance<S>);
    const Plucker<S> pl = line.plucker(), pl_moved = T * pl;
    Vec<S, 6> nv, nv_moved;
    nv << pl.n, pl.v;
    nv_moved << pl_moved.n, pl_moved.v;
    REQUIRE((plucker_transform(T) * nv - nv_moved).norm() < 5 * tolerance<S>);
    REQUIRE(pl.n.squaredNorm() + pl.v.squaredNorm() == Approx(1));
    REQUIRE(std::abs(pl.n.dot(pl.v)) < tolerance<S>);
  }
}

TEMPLATE_TEST_CASE("line3: points seen along rays, and the plane that faces the origin", "", float, double) {
  using S = TestType;
  Random random(2);
  for (int i = 0; i < 100; ++i) {
    const Vec<S, 3> p = random_vector<S>(random, 1) + Vec<S, 3>(0, 0, 3), q = random_vector<S>(random, 1) + p;
    const Plucker<S> line = Line3<S>::through(p, q).plucker();
    for (const Vec<S, 3>& X : {p, q}) {
      REQUIRE((line.point_along(X.normalized()) - X).norm() < 20 * tolerance<S>);
      REQUIRE(line.facing_plane().dot(X) == Approx(1).margin(20 * tolerance<S>));
    }
    // beside the line: the point found lies on it, and in the plane of the ray and the image normal
    const Vec<S, 3> ray = (p + S(0.02) * line.n.normalized()).normalized(), X = line.point_along(ray);
    REQUIRE(distance(Line3<S>(line), X) < 20 * tolerance<S>);
    REQUIRE(std::abs(X.dot(ray.cross(line.n.normalized()))) < 20 * tolerance<S>);
  }
}

TEMPLATE_TEST_CASE("line3: plus and minus are inverse, with their Jacobians", "", float, double) {
  using S = TestType;
  Random random(3);
  for (int i = 0; i < 100; ++i) {
    const Line3<S> line0 = Line3<S>::through(random_vector<S>(random, 3), random_vector<S>(random, 3));
    Vec<S, 4> d;
    d << random_vector<S>(random, 1), S(random.uniform() - 0.5) * line0.w2();  // w2 stays positive
    const Line3<S> line1 = plus(line0, d);
    REQUIRE((minus(line1, line0) - d).norm() < 20 * tolerance<S>);
    REQUIRE(line1.w1() * line1.w1() + line1.w2() * line1.w2() == Approx(1));
    const Line3<double> line1_d = line1.template cast<double>(), line0_d = line0.template cast<double>();
    if (line1.w1() > 0) {
      REQUIRE(testing::jacobian_error(
                  minus_jacobian(line1, line0), [&](const Line3<double>& x) { return minus(x, line0_d); }, line1_d) <
              (std::is_same_v<S, float> ? 1e-4 : 1e-9));
    }
    const auto coordinates = [](const Line3<double>& x) -> Vec<double, 6> {
      Vec<double, 6> nv;
      nv << x.plucker().n, x.plucker().v;
      return nv;
    };
    REQUIRE(testing::jacobian_error(line0.plucker_jacobian(), coordinates, line0_d) <
            (std::is_same_v<S, float> ? 1e-5 : 1e-9));
  }
}

TEMPLATE_TEST_CASE("line3: through the origin and far away", "", float, double) {
  using S = TestType;
  const Line3<S> central = Line3<S>::through({0, 0, 1}, {0, 0, 2});
  REQUIRE(central.is_finite());
  REQUIRE(central.distance() < tolerance<S>);
  REQUIRE((central.direction() - Vec<S, 3>::UnitZ()).norm() < tolerance<S>);
  // a step over the origin: the distance changes its side, the line stays one
  const Line3<S> near = Line3<S>::through({S(0.01), 0, 1}, {S(0.01), 0, 2});
  const Line3<S> over = plus(near, Vec<S, 4>(0, 0, 0, S(0.02)));
  REQUIRE(over.w1() < 0);
  REQUIRE(over.w2() > 0);
  REQUIRE(std::abs(over.distance() - S(0.01)) < S(1e-4));
  REQUIRE((over.closest_point() + near.closest_point()).norm() < S(1e-4));
  const Line3<S> far = Line3<S>::through({S(1e4), 0, 0}, {S(1e4), 1, 0});
  REQUIRE(far.distance() == Approx(1e4));
}

TEST_CASE("line3: coincident points and NaN give no finite line") {
  const Vec<double, 3> p(1, 2, 3);
  REQUIRE_FALSE(Line3<double>::through(p, p).is_finite());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(Line3<double>::through(p, {0, nan, 0}).is_finite());
}
