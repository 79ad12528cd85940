#include "plumbline/residual/collinear_world_point.hpp"

#include "catch.hpp"
#include "plumbline/testing/gaussian.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

TEMPLATE_TEST_CASE("collinear_world_point: Jacobians", "", float, double) {
  using S = TestType;
  const double tolerance = std::is_same_v<S, float> ? 2e-4 : 1e-8;
  testing::Gaussian noise(1);
  for (int n = 0; n < 50; ++n) {
    const Vec<double, 3> a = Vec<double, 3>(0, 0, 4) + noise.vector<3>(), center = 0.3 * noise.vector<3>();
    const Line3<double> line = Line3<double>::through(a, a + noise.vector<3>());
    const Vec<double, 3> X = a + 0.5 * noise.vector<3>();
    using Exact = CollinearWorldPoint<double>;
    const auto lin = CollinearWorldPoint<S>::linearize(line.cast<S>(), cast_to<S>(X), cast_to<S>(center));
    REQUIRE(lin.valid);
    CHECK((cast_to<double>(lin.r) - Exact::residual(line, X, center)).norm() < tolerance);
    CHECK((lin.r - CollinearWorldPoint<S>::residual(line.cast<S>(), cast_to<S>(X), cast_to<S>(center))).norm() <
          S(1e-6));
    const auto by_point = [&](const Vec<double, 3>& x) { return Exact::residual(line, x, center); };
    const auto by_center = [&](const Vec<double, 3>& x) { return Exact::residual(line, X, x); };
    const auto by_line = [&](const Line3<double>& x) { return Exact::residual(x, X, center); };
    CHECK(testing::jacobian_error(lin.J_r_point, by_point, X) < tolerance);
    CHECK(testing::jacobian_error(lin.J_r_center, by_center, center) < tolerance);
    CHECK(testing::jacobian_error(lin.J_r_line, by_line, line) < tolerance);
  }
}

TEST_CASE("collinear_world_point: distance by range, whatever the unit") {
  const Vec<double, 3> X(0.3, 0.2, 5), center(0.3, 0.2, 1), on_line(0, 0, 5);
  for (const double scale : {1.0, 0.01, 100.0}) {
    const auto line = Line3<double>::through(scale * on_line, scale * (on_line + Vec<double, 3>(1, 0, 0)));
    CHECK(norm(CollinearWorldPoint<double>::residual(line, scale * X, scale * center)) == Approx(0.2 / 4));
  }
  CHECK(!CollinearWorldPoint<double>::linearize(Line3<double>(), X, X).valid);
}
