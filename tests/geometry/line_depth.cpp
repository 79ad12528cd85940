#include "plumbline/geometry/line_depth.hpp"

#include <limits>
#include <vector>

#include <Eigen/LU>

#include "catch.hpp"
#include "plumbline/core/random.hpp"

using namespace plumbline;

namespace {

struct Noise {
  Random random;
  double operator()(double sigma) {
    double sum = -6;
    for (int i = 0; i < 12; ++i) sum += random.uniform();
    return sigma * sum;
  }
};

template <class S>
std::vector<LineDepthSample<S>> samples_of(double l_a, double l_b, int n, double sigma, Noise& noise) {
  std::vector<LineDepthSample<S>> out;
  for (int k = 0; k < n; ++k) {
    const double s = (k + 0.5) / n;
    out.push_back({S(s), S((1 - s) * l_a + s * l_b + noise(sigma)), S(sigma)});
  }
  return out;
}

template <class S>
LineDepth<S> fit(const std::vector<LineDepthSample<S>>& samples, const LineDepthOptions& options = {}) {
  return fit_line_depth(std::span<const LineDepthSample<S>>(samples), options);
}

}  // namespace

TEST_CASE("line_depth: inverse depth is affine along a segment on the plane z = 1") {
  const Vec<double, 3> p(-0.4, -0.3, 1.2), q(0.9, 0.2, 3.8);
  const Vec<double, 3> m_p = p / p.z(), m_q = q / q.z();
  for (double t = 0; t <= 1; t += 0.1) {
    const Vec<double, 3> X = p + t * (q - p), m = X / X.z();
    const double s = along_segment(m, m_p, m_q);
    REQUIRE((1 - s) / p.z() + s / q.z() == Approx(1 / X.z()));
  }
  const Line3<double> line = line_from_depth(m_p, m_q, Vec<double, 2>(1 / p.z(), 1 / q.z()));
  REQUIRE((line.plucker().point_along(p) - p).norm() < 1e-12);
  REQUIRE((line.direction() - (q - p).normalized()).norm() < 1e-12);
}

TEMPLATE_TEST_CASE("line_depth: the noise of the result is the predicted one", "", float, double) {
  using S = TestType;
  Noise noise{Random(1)};
  const Vec<double, 2> truth(0.5, 0.3);
  LineDepthOptions options;
  options.independent_samples = 1000;  // here they are
  double mahalanobis = 0;
  int n = 0;
  for (; n < 500; ++n) {
    const LineDepth<S> found = fit(samples_of<S>(truth[0], truth[1], 30, 3e-3, noise), options);
    REQUIRE(found.valid);
    REQUIRE(found.inliers >= 26);
    const Vec<double, 2> d = found.inverse_depth.template cast<double>() - truth;
    mahalanobis += d.dot(found.covariance.template cast<double>().inverse() * d);
  }
  REQUIRE(mahalanobis / n == Approx(2).epsilon(0.2));
  // correlated samples: eight count, however many there are
  const auto trace = [&](int samples) {
    return fit(samples_of<S>(truth[0], truth[1], samples, 3e-3, noise)).covariance.trace();
  };
  REQUIRE(trace(60) == Approx(trace(30)).epsilon(0.15));
}

TEMPLATE_TEST_CASE("line_depth: the nearer side of an occluding edge, and outliers", "", float, double) {
  using S = TestType;
  Noise noise{Random(2)};
  int both = 0;  // samples of equal sides that were taken together
  for (int i = 0; i < 100; ++i) {
    const double sigma = 3e-3;
    const auto near = samples_of<S>(0.5, 0.45, 24, sigma, noise), far = samples_of<S>(0.2, 0.22, 24, sigma, noise),
               same = samples_of<S>(0.5, 0.45, 24, sigma, noise);
    std::vector<LineDepthSample<S>> edge, texture, broken;
    for (std::size_t k = 0; k < near.size(); ++k) {
      edge.push_back(k % 2 == 0 ? nearer_side(near[k], far[k]) : nearer_side(far[k], near[k]));
      texture.push_back(nearer_side(near[k], same[k]));
      broken.push_back(k % 3 == 1 ? far[k] : near[k]);  // one in three has lost the near side
      both += texture.back().sigma == Approx(sigma / std::sqrt(2.0));
    }
    for (const auto& samples : {edge, texture, broken}) {
      const LineDepth<S> found = fit(samples);
      REQUIRE(found.valid);
      REQUIRE(found.inverse_depth[0] == Approx(0.5).margin(5e-3));
      REQUIRE(found.inverse_depth[1] == Approx(0.45).margin(5e-3));
    }
    REQUIRE(fit(broken).inliers <= 17);
  }
  REQUIRE(both > 0.99 * 2400);
}

TEMPLATE_TEST_CASE("line_depth: not valid without agreement, extent, certainty or samples", "", float, double) {
  using S = TestType;
  Noise noise{Random(3)};
  std::vector<LineDepthSample<S>> scattered = samples_of<S>(0.5, 0.45, 24, 3e-3, noise);
  for (std::size_t k = 0; k < scattered.size(); k += 2) scattered[k].inverse_depth = S(0.1 + noise.random.uniform());
  REQUIRE_FALSE(fit(scattered).valid);
  auto one_end = samples_of<S>(0.5, 0.45, 40, 3e-3, noise);
  one_end.resize(14);  // the first third
  REQUIRE_FALSE(fit(one_end).valid);
  REQUIRE_FALSE(fit(samples_of<S>(0.05, 0.04, 24, 1e-2, noise)).valid);  // 20 m
  REQUIRE_FALSE(fit(samples_of<S>(-0.5, -0.4, 24, 3e-3, noise)).valid);
  REQUIRE_FALSE(fit(samples_of<S>(0.5, 0.4, 2, 3e-3, noise)).valid);
  REQUIRE_FALSE(fit<S>({}).valid);
  auto nan = samples_of<S>(0.5, 0.45, 24, 3e-3, noise);
  for (auto& x : nan) x.inverse_depth = std::numeric_limits<S>::quiet_NaN();
  REQUIRE_FALSE(fit(nan).valid);
}
