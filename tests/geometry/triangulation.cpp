#include "plumbline/geometry/triangulation.hpp"

#include <array>
#include <limits>

#include "catch.hpp"
#include "plumbline/core/random.hpp"
#include "plumbline/testing/numeric_jacobian.hpp"

using namespace plumbline;

namespace {

Vec<double, 3> random_vector(Random& random) {
  return {2 * random.uniform() - 1, 2 * random.uniform() - 1, 2 * random.uniform() - 1};
}
double normal(Random& random) {
  double sum = -6;
  for (int i = 0; i < 12; ++i) sum += random.uniform();
  return sum;
}

constexpr std::size_t view_count = 5;

struct Truth {
  Vec<double, 3> bearing_anchor;
  double inverse_range;
};

/// A point seen from cameras up to 0.5 m apart, bearings disturbed by `noise` [rad].
template <class S>
Truth make_views(Random& random, double noise, std::array<TriangulationView<S>, view_count>& views) {
  const Vec<double, 3> p_ca{random_vector(random).x(), random_vector(random).y(), 2 + 4 * random.uniform()};
  for (auto& view : views) {
    Vec<double, 6> xi;
    xi << 0.2 * random_vector(random), 0.5 * random_vector(random);
    const SE3<double> T = SE3<double>::exp(xi);
    const Vec<double, 3> p = T * p_ca, b = p.normalized(), e{normal(random), normal(random), normal(random)};
    view = {T.cast<S>(), (b + noise * (e - b * b.dot(e))).normalized().template cast<S>(), S(2e-3)};
  }
  return {p_ca.normalized(), 1 / p_ca.norm()};
}

}  // namespace

TEMPLATE_TEST_CASE("triangulation: exact without noise", "", float, double) {
  using S = TestType;
  Random random(1);
  for (int trial = 0; trial < 300; ++trial) {
    std::array<TriangulationView<S>, view_count> views;
    const Truth truth = make_views<S>(random, 0, views);
    const double tolerance = std::is_same_v<S, float> ? 1e-4 : 1e-10;
    const Vec<S, 3> anchor = truth.bearing_anchor.cast<S>();
    const auto many = triangulate<S>(anchor, views);
    REQUIRE(many.valid);
    CHECK(double(many.inverse_range) == Approx(truth.inverse_range).epsilon(tolerance));
    for (const auto& view : views) {
      const auto one = triangulate<S>(anchor, {&view, 1});
      if (!one.valid) continue;  // little parallax
      CHECK(double(one.inverse_range) == Approx(truth.inverse_range).epsilon(200 * tolerance));
      CHECK(double(two_view_inverse_range(anchor, view)) == Approx(truth.inverse_range).epsilon(200 * tolerance));
      CHECK(many.variance <= one.variance);
    }
  }
}

TEMPLATE_TEST_CASE("triangulation: errors have the stated variance", "", float, double) {
  using S = TestType;
  Random random(2);
  double sum = 0, chi2 = 0;
  int count = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    std::array<TriangulationView<S>, view_count> views;
    const Truth truth = make_views<S>(random, 2e-3, views);
    const auto result = triangulate<S>(truth.bearing_anchor.cast<S>(), views);
    if (!result.valid) continue;
    const double e = double(result.inverse_range) - truth.inverse_range;
    sum += e * e / double(result.variance);
    chi2 += double(result.chi2);
    ++count;
  }
  CHECK(count > 2900);
  CHECK(sum / count == Approx(1).margin(0.12));
  CHECK(chi2 / count == Approx(2 * view_count - 1).margin(0.5));
}

TEMPLATE_TEST_CASE("triangulation: derivative by the inverse range", "", float, double) {
  using S = TestType;
  Random random(4);
  for (int trial = 0; trial < 100; ++trial) {
    std::array<TriangulationView<S>, view_count> views;
    const Truth truth = make_views<S>(random, 0, views);
    const auto result = triangulate<S>(truth.bearing_anchor.cast<S>(), {views.data(), 1});
    const SE3<double> T = views[0].T_cj_ca.template cast<double>();
    const auto predict = [&](const Vec<double, 1>& x) -> Vec<double, 3> {
      return (T.rotation() * truth.bearing_anchor + x[0] * T.p()).normalized();
    };
    const Mat<double, 3, 1> J = testing::numeric_jacobian<3, 1>(predict, Vec<double, 1>(double(result.inverse_range)));
    CHECK(double(result.variance) * J.squaredNorm() / 4e-6 ==
          Approx(1).epsilon(std::is_same_v<S, float> ? 1e-4 : 1e-7));
  }
}

TEMPLATE_TEST_CASE("triangulation: rejects no parallax, points behind, wrong matches and NaN", "", float, double) {
  using S = TestType;
  using View = TriangulationView<S>;
  const Vec<S, 3> anchor(0, 0, 1);
  const auto valid = [&](const View& view) { return triangulate<S>(anchor, {&view, 1}).valid; };
  const auto at = [](S x, S z) { return Vec<S, 3>(x, 0, z).normalized().eval(); };
  const SE3<S> right(SO3<S>(), {-1, 0, 0});  // a camera 1 m to the right
  CHECK(valid({right, at(-1, 4), S(2e-3)}));
  CHECK(!valid({SE3<S>(), at(-1, 4), S(2e-3)}));                             // no baseline
  CHECK(!valid({SE3<S>(SO3<S>(), {0, 0, -1}), anchor, S(2e-3)}));            // moves along the bearing
  CHECK(!valid({right, at(S(-1e-3), 1), S(2e-3)}));                          // parallax below the noise
  CHECK(!valid({right, at(1, 4), S(2e-3)}));                                 // rays diverge: negative depth
  CHECK(!valid({right, Vec<S, 3>(-1, 1, 4).normalized().eval(), S(2e-3)}));  // rays pass far from each other
  CHECK(!triangulate<S>(anchor, {}).valid);
  const S nan = std::numeric_limits<S>::quiet_NaN();
  CHECK(!valid({right, {nan, 0, 1}, S(2e-3)}));
  CHECK(!valid({right, at(-1, 4), nan}));
  CHECK(!valid({SE3<S>(SO3<S>(), {nan, 0, 0}), at(-1, 4), S(2e-3)}));
  const std::array<View, 2> mixed{View{right, at(-1, 4), S(2e-3)}, View{right, {nan, 0, 1}, S(2e-3)}};
  CHECK(!triangulate<S>(anchor, mixed).valid);
}
