#include "plumbline/geometry/line_triangulation.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

using V3 = Vec<double, 3>;

struct Noise {
  Random random;
  double operator()(double sigma) {  // nearly normal: sum of twelve uniform numbers
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform();
    return sigma * sum;
  }
};

/// A segment, seen from cameras at the given places; the endpoints seen differ from view to view.
template <class S>
std::vector<LineTriangulationView<S>> views_of(const V3& p, const V3& q, const std::vector<V3>& places, Noise& noise,
                                               double sigma_rad, double turn = 0.1) {
  std::vector<LineTriangulationView<S>> views;
  for (std::size_t j = 0; j < places.size(); ++j) {
    const V3 phi = j == 0 ? V3::Zero() : V3{noise(turn / 2), noise(turn / 2), noise(turn / 2)};
    const SE3<double> T_cj_ca = SE3<double>(SO3<double>::exp(phi), places[j]).inverse();
    const double cut = j == 0 ? 0 : 0.2 * noise.random.uniform();
    const V3 a = (T_cj_ca * V3(p + cut * (q - p))).normalized(), b = (T_cj_ca * V3(q - cut * (q - p))).normalized();
    const V3 m = a.cross(b).normalized();
    views.push_back({T_cj_ca.cast<S>(), V3(a + noise(sigma_rad) * m).normalized().cast<S>(),
                     V3(b + noise(sigma_rad) * m).normalized().cast<S>(), S(std::max(sigma_rad, 1e-4))});
  }
  return views;
}

template <class S>
LineTriangulation<S> triangulate(const std::vector<LineTriangulationView<S>>& views) {
  return triangulate_line(std::span<const LineTriangulationView<S>>(views));
}

const std::vector<V3> around = {V3(0, 0, 0), V3(0.3, 0.1, 0), V3(-0.2, 0.25, 0.1), V3(0.1, -0.3, 0.2)};

}  // namespace

TEMPLATE_TEST_CASE("line_triangulation: exact views give the line, two of them or more", "", float, double) {
  using S = TestType;
  Noise noise{Random(1)};
  int valid = 0;
  for (int i = 0; i < 60; ++i) {
    const V3 p{noise(0.5), noise(0.5), 2 + noise(0.2)}, q = p + V3{noise(0.5), noise(0.5), noise(0.5)};
    for (const std::size_t n : {2u, 4u}) {
      const auto views =
          views_of<S>(p, q, std::vector<V3>(around.begin(), around.begin() + std::ptrdiff_t(n)), noise, 0);
      const LineTriangulation<S> found = triangulate<S>(views);
      if (!found.valid) continue;
      ++valid;
      const S tolerance = std::is_same_v<S, float> ? S(2e-3) : S(1e-8);
      REQUIRE((found.line.direction() - (q - p).normalized().cast<S>()).norm() < 5 * tolerance);
      REQUIRE((found.line.plucker().point_along(views[0].bearing_start) - p.cast<S>()).norm() < 5 * tolerance);
      REQUIRE(found.inverse_depth[0] == Approx(1 / p.z()).epsilon(double(5 * tolerance)));
      REQUIRE(found.inverse_depth[1] == Approx(1 / q.z()).epsilon(double(5 * tolerance)));
      REQUIRE(found.chi2 < S(0.1));
    }
  }
  REQUIRE(valid > 70);
}

TEMPLATE_TEST_CASE("line_triangulation: the noise of the result is the predicted one", "", float, double) {
  using S = TestType;
  Noise noise{Random(2)};
  double sum[2] = {0, 0}, mahalanobis = 0, chi2 = 0;
  int n = 0;
  const V3 p(-0.4, -0.3, 2.2), q(0.5, 0.2, 2.8);
  const Line3<double> truth = Line3<double>::through(p, q);
  for (int i = 0; i < 600; ++i) {
    const auto views = views_of<S>(p, q, around, noise, 1e-3);
    const LineTriangulation<S> found = triangulate<S>(views);
    REQUIRE(found.valid);
    // inverse depth where the noisy end of the first view looks at the true line
    const V3 m = views[0].bearing_start.template cast<double>() / double(views[0].bearing_start.z());
    const double expected = truth.plucker().facing_plane().dot(m);
    const double error = (double(found.inverse_depth[0]) - expected) / double(found.sigma_inverse_depth[0]);
    sum[0] += error;
    sum[1] += error * error;
    const Vec<double, 4> d = minus(found.line.template cast<double>(), truth);
    mahalanobis += d.dot(found.covariance.template cast<double>().inverse() * d);
    chi2 += double(found.chi2);
    ++n;
  }
  REQUIRE(std::abs(sum[0] / n) < 0.15);
  REQUIRE(sum[1] / n == Approx(1).epsilon(0.2));
  REQUIRE(mahalanobis / n == Approx(4).epsilon(0.15));
  REQUIRE(chi2 / n == Approx(4).epsilon(0.15));  // 8 rows, 4 parameters
}

TEMPLATE_TEST_CASE("line_triangulation: nothing without parallax", "", float, double) {
  using S = TestType;
  Noise noise{Random(3)};
  const V3 p(-0.5, 0.3, 2), q(0.5, 0.3, 2);
  for (int i = 0; i < 40; ++i) {
    const double sigma = 1e-3;
    // turning only
    REQUIRE_FALSE(triangulate<S>(views_of<S>(p, q, {V3(0, 0, 0), V3(0, 0, 0), V3(0, 0, 0)}, noise, sigma)).valid);
    // a baseline along the line, and one within the plane of line and center
    REQUIRE_FALSE(triangulate<S>(views_of<S>(p, q, {V3(0, 0, 0), V3(0.4, 0, 0)}, noise, sigma)).valid);
    REQUIRE_FALSE(triangulate<S>(views_of<S>(p, q, {V3(0, 0, 0), V3(0.1, 0.045, 0.3)}, noise, sigma)).valid);
    // across: fine
    REQUIRE(triangulate<S>(views_of<S>(p, q, {V3(0, 0, 0), V3(0, 0.4, 0)}, noise, sigma)).valid);
    // far away
    const V3 far_p(-20, 10, 80), far_q(20, 10, 80);
    REQUIRE_FALSE(triangulate<S>(views_of<S>(far_p, far_q, around, noise, sigma)).valid);
  }
}

TEST_CASE("line_triangulation: wrong matches, lines behind, one view and NaN") {
  Noise noise{Random(4)};
  const V3 p(-0.4, -0.3, 2.2), q(0.5, 0.2, 2.8);
  auto views = views_of<double>(p, q, around, noise, 1e-3);
  REQUIRE(triangulate<double>(views).valid);
  const auto other = views_of<double>(p + V3(0, 0.2, 0), q + V3(0, 0.3, 0.2), around, noise, 1e-3);
  auto wrong = views;
  wrong[2] = other[2];
  REQUIRE_FALSE(triangulate<double>(wrong).valid);
  auto behind = views;  // the second camera stepped to the other side: the planes meet behind the cameras
  behind.resize(2);
  behind[1].T_cj_ca = SE3<double>(behind[1].T_cj_ca.rotation(), V3(-behind[1].T_cj_ca.p()));
  REQUIRE_FALSE(triangulate<double>(behind).valid);
  REQUIRE_FALSE(triangulate<double>({views[0]}).valid);
  REQUIRE_FALSE(triangulate<double>({}).valid);
  views[1].bearing_end.x() = std::numeric_limits<double>::quiet_NaN();
  REQUIRE_FALSE(triangulate<double>(views).valid);
}
